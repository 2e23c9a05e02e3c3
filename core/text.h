#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// A string stream that throws std::bad_alloc when memory runs out. The standard one continues
/// silently, so that a table or a figure would lack parts.
class TextStream : public std::ostringstream {
 public:
  TextStream() { exceptions(std::ios::badbit); }
};

/// `value` with that many decimals and a true minus sign; "2.50e+09" if it is too large for that, a
/// dash if it is not finite.
std::string fixed(double value, int decimals);

/// At most `digits` significant digits, up to 17: "0.05", "1e+06".
std::string with_digits(double value, int digits);

/// Six significant digits.
std::string number_text(double value);

/// Three significant digits: "0.0123", "5.40", "1230".
std::string three_digits(double value);

/// All characters of UTF-8 text; bytes that are not UTF-8 (overlong forms and surrogates among
/// them) become U+FFFD.
std::vector<char32_t> code_points(std::string_view text);

/// Appends one character in UTF-8, U+FFFD for a number that is no character.
void append_utf8(std::string& text, char32_t point);

/// True for control characters (C0, DEL, C1), for those that change the direction of the text
/// around them (U+202A ... U+202E, U+2066 ... U+2069), and for U+FFFE and U+FFFF of every plane.
bool is_control(char32_t point);

/// Untrusted text as one line that is safe in a message, a record or on a terminal: valid UTF-8, a
/// space for each tab and line end, U+FFFD for any other control character. Text longer than `most`
/// characters is cut and ends in "…".
std::string printable(std::string_view text, std::size_t most = 200);

/// As printable, for the path of a file, which is never cut: systems limit paths to 4096 bytes.
inline std::string printable_path(std::string_view path) { return printable(path, 4096); }

/// As printable, with its line ends kept as '\n'.
std::string printable_lines(std::string_view text, std::size_t most = std::string_view::npos);

/// Number of characters of UTF-8 text.
std::size_t character_count(std::string_view text);

/// One line of at most `length` characters, runs of white space as one space; ends in "…" if cut.
std::string one_line(std::string_view text, std::size_t length);

/// `text` in lines of at most `width` characters, broken at white space and after hyphens and
/// underscores; words longer than a line are broken anywhere.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);

/// `text` with `to` in the place of each `from`, which is not empty.
std::string replaced(std::string text, std::string_view from, std::string_view to);

/// `text` as one word of a shell.
inline std::string shell_quoted(const std::string& text) {
  return "'" + replaced(text, "'", "'\\''") + "'";
}

/// Parts of `text` between the separators; the whole text if it has none.
std::vector<std::string> split(std::string_view text, std::string_view separator);

/// The whole number that `text` is; nothing where it is anything else.
template <typename Number>
std::optional<Number> whole_number(std::string_view text) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? std::optional(value) : std::nullopt;
}

/// The word of `known` that `word` is most likely a misspelling or an abbreviation of; empty if
/// none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

/// `text` as one printable line of Markdown without markup: no emphasis, HTML, link, formula or
/// table column.
std::string markdown_escaped(std::string_view text);

/// `text` for the content or a quoted attribute of HTML and SVG: markup escaped, bytes that are not
/// UTF-8 as U+FFFD, control characters (is_control) other than tab and new line removed.
std::string html_escaped(std::string_view text);

/// A CSV field by RFC 4180, quoted if it holds a comma, a quote or a line end. Text that a
/// spreadsheet would evaluate, because it begins with "=", "+", "-" or "@" after any white space,
/// gets an apostrophe in front (OWASP, CSV injection); numbers do not.
std::string csv_field(std::string_view text);
/// Fields of each line of CSV text, without quotes and the apostrophes of csv_field. The last line
/// needs no line end.
std::vector<std::vector<std::string>> csv_lines(std::string_view text);
/// Six significant digits; empty without a value.
std::string csv_number(const std::optional<double>& value);

}  // namespace ertbench
