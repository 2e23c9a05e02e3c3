#include "frames/text_lines.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::string_view blanks = " \t\r";

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string_view unquoted(std::string_view text) {
  for (const char quote : {'"', '\''}) {
    if (text.size() > 1 && text.front() == quote && text.back() == quote) {
      return trimmed(text.substr(1, text.size() - 2));
    }
  }
  return text;
}

void append_utf8(unsigned unit, std::string& out) {
  if (unit < 0x80) {
    out += static_cast<char>(unit);
  } else if (unit < 0x800) {
    out += static_cast<char>(0xc0 | unit >> 6U);
    out += static_cast<char>(0x80 | (unit & 0x3fU));
  } else {
    out += '?';  // nothing that a table of voltages needs
  }
}

std::string utf8_of_utf16(std::string_view bytes, bool little) {
  std::string out;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes[i]);
    const auto second = static_cast<unsigned char>(bytes[i + 1]);
    append_utf8(little ? first + 256U * second : 256U * first + second, out);
  }
  return out;
}

/// Reads a number at the beginning of `text` and takes it off.
std::optional<double> leading_number(std::string_view& text, bool decimal_comma) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::string copy;
  std::string_view view = text;
  if (decimal_comma) {
    copy = text;
    if (copy.find('.') != std::string::npos) return std::nullopt;
    std::ranges::replace(copy, ',', '.');
    view = copy;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), value);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - view.data()));
  return value;
}

/// Whether `text` is the imaginary part behind a real one: "+0.3i", "-j0.3", ",0.3" in parentheses.
bool is_imaginary(std::string_view text, bool in_parentheses, bool decimal_comma) {
  const auto is_i = [](char c) {
    return std::string_view("ijIJ").find(c) != std::string_view::npos;
  };
  if (in_parentheses && text.starts_with(',')) {
    text.remove_prefix(1);
  } else if (text.size() > 1 && (text.front() == '+' || text.front() == '-')) {
    text.remove_prefix(1);
    if (is_i(text.front()) == is_i(text.back())) return text.size() == 1 && is_i(text.front());
    is_i(text.front()) ? text.remove_prefix(1) : text.remove_suffix(1);
    if (text.starts_with('*')) text.remove_prefix(1);
    if (text.ends_with('*')) text.remove_suffix(1);
  } else {
    return false;
  }
  return leading_number(text, decimal_comma) && text.empty();
}

}  // namespace

std::string utf8_text(std::string bytes, const std::string& source) {
  if (bytes.starts_with("\xff\xfe")) return utf8_of_utf16(std::string_view(bytes).substr(2), true);
  if (bytes.starts_with("\xfe\xff")) return utf8_of_utf16(std::string_view(bytes).substr(2), false);
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.erase(0, 3);
  if (bytes.find('\0') == std::string::npos) return bytes;
  const auto is_zero = [&](std::size_t i) { return i < bytes.size() && bytes[i] == '\0'; };
  if (bytes.size() > 4 && is_zero(1) && is_zero(3) && !is_zero(0))
    return utf8_of_utf16(bytes, true);
  if (bytes.size() > 4 && is_zero(0) && is_zero(2) && !is_zero(1)) {
    return utf8_of_utf16(bytes, false);
  }
  throw InputError(source +
                   ": is neither text nor a binary format that is known; save the frames as text, "
                   "one a line, or as HDF5");
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

std::optional<std::string_view> NumberedLines::next() {
  if (rest_.empty()) return std::nullopt;
  const std::size_t end = rest_.find('\n');
  const std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++number_;
  return trimmed(line);
}

void NumberedLines::fail(const std::string& what) const {
  throw InputError(source_ + ": line " + std::to_string(number_) + ": " + what);
}

std::vector<double> NumberedLines::numbers(std::string_view line) const {
  std::vector<double> values;
  while (true) {
    const std::size_t first = line.find_first_not_of(" \t,");
    if (first == std::string_view::npos) return values;
    line.remove_prefix(first);
    const std::string_view word = line.substr(0, line.find_first_of(" \t,"));
    const char* const begin = word.data() + (word.front() == '+');
    double value = 0;
    const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      fail("must hold finite numbers, holds \"" + printable(word, 40) + "\"");
    }
    values.push_back(value);
    line.remove_prefix(word.size());
  }
}

std::string_view without_prefix(std::string_view line, std::string& prefix) {
  prefix.clear();
  const std::string_view whole = line;
  const std::size_t start = line.find_first_not_of("{\"' ");  // also {"v": [
  std::size_t end = line.find("->");
  if (end != std::string_view::npos) {
    end += 2;
  } else if (start < line.size() && is_letter(line[start])) {
    end = line.find_first_of(":=,;\t");
    if (end == std::string_view::npos) {
      // Words, and what is left begins with a number.
      end = 0;
      const auto word = [&] { return line.substr(end, line.find_first_of(blanks, end) - end); };
      while (end < line.size() && is_letter(line[end]) && !is_missing_mark(word())) {
        end =
            std::min(line.size(), line.find_first_not_of(blanks, line.find_first_of(blanks, end)));
      }
    } else if (line[end] == ':' || line[end] == '=') {
      ++end;
    } else {
      end = 0;
    }
  } else {
    end = 0;
  }
  std::string_view rest = trimmed(line.substr(end));
  while (!rest.empty() && (rest.front() == '[' || rest.front() == '{')) rest.remove_prefix(1);
  while (!rest.empty() && (rest.back() == ']' || rest.back() == '}')) rest.remove_suffix(1);
  rest = trimmed(rest);
  const bool is_number =
      !rest.empty() && (is_digit(rest.front()) ||
                        std::string_view("+-.,;\"(").find(rest.front()) != std::string_view::npos);
  if (end > 0 && !is_number) return whole;
  prefix = trimmed(whole.substr(0, end));
  return rest;
}

NumberFormat number_format_of(std::string_view line) {
  constexpr std::array<NumberFormat, 8> formats = {{{';', false},
                                                    {';', true},
                                                    {'\t', false},
                                                    {'\t', true},
                                                    {',', false},
                                                    {',', true},
                                                    {' ', false},
                                                    {' ', true}}};
  NumberFormat best{',', false};
  double best_share = -1;
  for (const NumberFormat& format : formats) {
    if (format.separator != ' ' && line.find(format.separator) == std::string_view::npos) continue;
    const std::vector<std::string_view> fields = fields_of(line, format);
    bool ignored = false;
    const auto numbers = std::ranges::count_if(fields, [&](std::string_view field) {
      return field.empty() || number_of(field, format, ignored);
    });
    const double share =
        static_cast<double>(numbers) / static_cast<double>(std::max<std::size_t>(1, fields.size()));
    if (share > best_share) {
      best_share = share;
      best = format;
    }
  }
  return best;
}

std::vector<std::string_view> fields_of(std::string_view line, const NumberFormat& format) {
  std::vector<std::string_view> fields;
  const bool by_blanks = format.separator == ' ';
  std::size_t begin = 0;
  char closing = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    const char c = i < line.size() ? line[i] : '\0';
    if (i < line.size() && closing != 0) {
      if (c == closing) closing = 0;
      continue;
    }
    if (c == '"' || c == '(') closing = c == '(' ? ')' : '"';
    const bool ends = i == line.size() || c == format.separator ||
                      (by_blanks && blanks.find(c) != std::string_view::npos);
    if (!ends) continue;
    const std::string_view field = trimmed(line.substr(begin, i - begin));
    begin = i + 1;
    if (by_blanks && field.empty()) continue;
    // A sign by itself joins the parts of a complex number.
    const bool is_sign = field == "+" || field == "-";
    const bool joins = by_blanks && !fields.empty() &&
                       (is_sign || fields.back().ends_with('+') || fields.back().ends_with('-'));
    if (joins) {
      const char* const first = fields.back().data();
      fields.back() = {first, static_cast<std::size_t>(field.data() + field.size() - first)};
    } else {
      fields.push_back(field);
    }
  }
  // Some programs end every number with a separator.
  if (fields.size() > 1 && fields.back().empty()) fields.pop_back();
  return fields;
}

std::optional<double> number_of(std::string_view field, const NumberFormat& format,
                                bool& is_complex) {
  std::string_view text = unquoted(field);
  const auto value = leading_number(text, format.decimal_comma);
  if (value && text.empty()) return value;
  std::string joined;
  for (const char c : unquoted(field)) {
    if (blanks.find(c) == std::string_view::npos) joined += c;
  }
  text = joined;
  const bool in_parentheses = text.size() > 2 && text.front() == '(' && text.back() == ')';
  if (in_parentheses) text = text.substr(1, text.size() - 2);
  const auto real = leading_number(text, format.decimal_comma && !in_parentheses);
  if (!real || !is_imaginary(text, in_parentheses, format.decimal_comma)) return std::nullopt;
  is_complex = true;
  return real;
}

bool is_missing_mark(std::string_view field) {
  const std::string text = lower(unquoted(field));
  constexpr std::string_view marks[] = {
      "",         "-",       "--",  "---",  "na",   "n/a",      "#n/a",      "nan", "null",
      "none",     "ovl",     "ol",  "over", "ovld", "overload", "overrange", "ovf", "ovr",
      "overflow", "missing", "inf", "-inf", "-nan", "*",        "?"};
  return std::find(std::begin(marks), std::end(marks), text) != std::end(marks);
}

bool is_title_line(std::string_view line) {
  constexpr std::size_t least_counted = 8;  // shorter lines may be rows of an order of channels
  const NumberFormat format = number_format_of(line);
  const std::vector<std::string_view> fields = fields_of(line, format);
  std::vector<double> numbers;
  bool has_words = false;
  for (const std::string_view field : fields) {
    bool is_complex = false;
    const auto value = number_of(field, format, is_complex);
    if (value) numbers.push_back(*value);
    has_words = has_words || (!value && !is_missing_mark(field));
  }
  if (numbers.empty()) return has_words;
  // The first title may be the one of the frames' numbers.
  bool counts = numbers.size() >= least_counted && numbers.size() + 1 >= fields.size() &&
                (numbers[0] == 0 || numbers[0] == 1);
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    counts = counts && numbers[i] == numbers[i - 1] + 1;
  }
  return counts;
}

bool counts_values(double value, std::size_t values) {
  const auto count = static_cast<double>(values);
  return values >= 8 && (value == count || value * value == count);
}

}  // namespace ertbench
