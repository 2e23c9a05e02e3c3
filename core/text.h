#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Text for people: numbers as they are read, UTF-8 counted in characters.
namespace ertbench {

/// `value` with that many decimals and a true minus sign; "2.50e+09" where it is too large for
/// that, a dash where it is not finite.
std::string fixed(double value, int decimals);

/// "0.05", "1e+06": `value` with six digits that count.
std::string number_text(double value);

/// Three digits that count: "0.0123", "5.40", "1230".
std::string three_digits(double value);

/// All characters of UTF-8 text; bytes that are not UTF-8 become U+FFFD.
std::vector<char32_t> code_points(std::string_view text);

/// The number of characters of UTF-8 text.
std::size_t character_count(std::string_view text);

/// One line of at most `length` characters, runs of white space as one space; "…" where it was cut.
std::string one_line(std::string_view text, std::size_t length);

/// `text` in lines of at most `width` characters, broken at white space and after hyphens and
/// underscores, within a word only where it is longer than a line.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);

/// The parts of `text` between the separators; one, maybe empty, where there is none.
std::vector<std::string> split(std::string_view text, std::string_view separator);

}  // namespace ertbench
