#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// How the numbers of a text stand in its lines.
struct NumberFormat {
  char separator = ',';  ///< ';', ',', '\t', or ' ' for any blanks
  bool decimal_comma = false;
};

/// The bytes of a text file as UTF-8; UTF-16 is recognised by its mark or its zeros. Throws
/// InputError, which begins with `source`, for binary files, with what they are.
std::string utf8_text(std::string bytes, const std::string& source);

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view trimmed(std::string_view text);

/// The lines of a text, whose numbers messages name.
class NumberedLines {
 public:
  NumberedLines(std::string_view text, std::string source)
      : rest_(text), source_(std::move(source)) {}

  /// The next line, trimmed; nothing after the last.
  std::optional<std::string_view> next();
  int number() const { return number_; }
  /// Throws InputError with the source and the line.
  [[noreturn]] void fail(const std::string& what) const;
  /// The finite numbers of a line, separated by tabs, blanks or commas. Fails for anything else.
  std::vector<double> numbers(std::string_view line) const;

 private:
  std::string_view rest_;
  std::string source_;
  int number_ = 0;
};

/// A line without the words before its numbers ("magnitudes : ", "POLAR ", "10:00:01.5 -> ") and
/// without brackets around them; `prefix` becomes these words.
std::string_view without_prefix(std::string_view line, std::string& prefix);

/// The format in which most fields of a line are numbers.
NumberFormat number_format_of(std::string_view line);

/// The fields of a line. Separators within quotes or parentheses are none.
std::vector<std::string_view> fields_of(std::string_view line, const NumberFormat& format);

/// The number that a whole field is, which may be quoted. A complex one ("1.2+0.3i", "1.2 + 0.3j",
/// "(1.2,0.3)") gives its real part, which is in phase, and sets `is_complex`.
std::optional<double> number_of(std::string_view field, const NumberFormat& format,
                                bool& is_complex);

/// Whether a field stands for a value that was not measured: "OVL", "overload", "--", "n/a".
bool is_missing_mark(std::string_view field);

/// Whether a line can only be column titles: it has fields, none of which is a number or a mark, or
/// they count the columns from 0 on, as pandas writes them.
bool is_title_line(std::string_view line);

/// Whether `value` says how many values follow, or of how many electrodes their square is.
bool counts_values(double value, std::size_t values);

/// What the title of a column says.
struct ColumnTitle {
  enum class Kind { value, magnitude, phase, real, imaginary, stamp };

  Kind kind = Kind::value;
  /// Driving and measuring electrodes as they are written: "E01_E09_E02_E10_Magnitude [mV]".
  std::optional<std::array<int, 4>> electrodes;
  std::string unit;  ///< "V", "mV", "uV", "deg", "rad", or empty
};

ColumnTitle column_title(std::string_view text);

/// How the columns of a table are read by their titles.
struct TitledColumns {
  struct Column {
    std::size_t value = 0;             ///< column of the table
    std::optional<std::size_t> phase;  ///< of the column whose phase belongs to this magnitude
  };

  std::vector<Column> columns;
  /// Driving and measuring electrodes of each, counted from 0; empty if the titles name none.
  std::vector<std::array<int, 4>> channels;
  std::string unit;        ///< of the values, empty if it is not said
  std::string phase_unit;  ///< "deg", "rad" or empty
};

/// Throws InputError, which begins with `source`, for channels that come twice and for units that
/// differ. Without electrodes in the titles all columns but stamps are taken.
TitledColumns titled_columns(const std::vector<std::string_view>& titles,
                             const std::string& source);

}  // namespace ertbench
