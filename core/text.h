#pragma once

#include <cstddef>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// A stream into a text that throws std::bad_alloc where memory runs out. The standard's own keeps
/// that to itself and goes on with less, so that a table or a figure would lack some of its parts.
class TextStream : public std::ostringstream {
 public:
  TextStream() { exceptions(std::ios::badbit); }
};

}  // namespace ertbench

/// Text for people: numbers as they are read, UTF-8 counted in characters.
namespace ertbench {

/// `value` with that many decimals and a true minus sign; "2.50e+09" where it is too large for
/// that, a dash where it is not finite.
std::string fixed(double value, int decimals);

/// "0.05", "1e+06": `value` with six digits that count.
std::string number_text(double value);

/// Three digits that count: "0.0123", "5.40", "1230".
std::string three_digits(double value);

/// All characters of UTF-8 text; bytes that are not UTF-8 (overlong forms and surrogates among
/// them) become U+FFFD.
std::vector<char32_t> code_points(std::string_view text);

/// Adds one character in UTF-8, U+FFFD in place of a number that is none.
void append_utf8(std::string& text, char32_t point);

/// Whether a terminal, a browser or a reader would obey this character instead of showing it: C0,
/// DEL and C1, and those that turn the direction of the text around them (U+202A ... U+202E,
/// U+2066 ... U+2069). Also what no text may hold: U+FFFE and U+FFFF of every plane.
bool is_control(char32_t point);

/// Text from elsewhere, which may be anything, as one line that may stand in a message, a record or
/// on a terminal: valid UTF-8, a space for each tab and line end, U+FFFD for any other control
/// character. Of longer text the first `most` characters and "…".
std::string printable(std::string_view text, std::size_t most = 200);

/// The same for the path of a file, which stays whole: no system has longer ones.
inline std::string printable_path(std::string_view path) { return printable(path, 4096); }

/// The same with its line ends kept, in which only '\n' is one.
std::string printable_lines(std::string_view text, std::size_t most = std::string_view::npos);

/// The number of characters of UTF-8 text.
std::size_t character_count(std::string_view text);

/// One line of at most `length` characters, runs of white space as one space; "…" where it was cut.
std::string one_line(std::string_view text, std::size_t length);

/// `text` in lines of at most `width` characters, broken at white space and after hyphens and
/// underscores, within a word only where it is longer than a line.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);

/// The parts of `text` between the separators; one, maybe empty, where there is none.
std::vector<std::string> split(std::string_view text, std::string_view separator);

/// The one of `known` that `word` is likely to be a slip for (few letters differ, or it begins the
/// same); empty where none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

/// `text` as one line of Markdown in which every character is what it is: no emphasis, HTML, link,
/// formula or new column of a table, and printable.
std::string markdown_escaped(std::string_view text);

/// `text` as it may stand in the content or a quoted attribute of HTML and SVG: markup escaped,
/// bytes that are not UTF-8 as U+FFFD, control characters (is_control) other than tab and new line
/// left out.
std::string html_escaped(std::string_view text);

/// A field as RFC 4180 has it: quoted where it holds a comma, a quote or a line end. A spreadsheet
/// would compute what begins with "=", "+", "-" or "@", behind blanks, tabs and line ends too; an
/// apostrophe before it makes it a text (OWASP, CSV injection). Numbers stay what they are.
std::string csv_field(std::string_view text);
/// The fields of each line of CSV text, quotes and the apostrophes of csv_field taken off; a last
/// line without an end counts.
std::vector<std::vector<std::string>> csv_lines(std::string_view text);
/// With six digits; empty where there is none.
std::string csv_number(const std::optional<double>& value);

}  // namespace ertbench
