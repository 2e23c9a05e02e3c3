
#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>

#include "core/errors.h"
#include "core/lists.h"
#include "frames/text_lines.h"

namespace ertbench {
namespace {

using Kind = ColumnTitle::Kind;

/// The words of a title in small letters, without the digits and signs between them.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0 || byte >= 0x80 || c == '|' || c == '#') {
      words.back() += static_cast<char>(byte < 0x80 ? std::tolower(byte) : byte);
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::optional<Kind> kind_of(const std::string& word) {
  const auto begins = [&](std::initializer_list<const char*> list) {
    return std::ranges::any_of(list, [&](const char* start) { return word.starts_with(start); });
  };
  if (begins({"mag", "abs", "amp", "mod", "|z", "|v"})) return Kind::magnitude;
  if (begins({"pha", "arg", "ang", "theta"})) return Kind::phase;
  if (begins({"real", "inphase"}) || word == "re") return Kind::real;
  if (begins({"imag", "quad"}) || word == "im") return Kind::imaginary;
  return std::nullopt;
}

bool is_stamp(const std::string& word) {
  constexpr std::string_view names[] = {"time",  "timestamp", "date",    "datetime", "clock",
                                        "frame", "frames",    "index",   "idx",      "sample",
                                        "scan",  "no",        "nr",      "number",   "id",
                                        "seq",   "sequence",  "counter", "count",    "unnamed",
                                        "epoch", "elapsed",   "#",       "t",        "n"};
  return std::find(std::begin(names), std::end(names), word) != std::end(names);
}

std::string unit_of(const std::string& word) {
  if (word == "v" || word == "volt" || word == "volts") return "V";
  if (word == "mv" || word == "millivolts") return "mV";
  if (word == "uv" || word == "µv" || word == "μv" || word == "microvolts") return "uV";
  if (word == "deg" || word == "degree" || word == "degrees" || word == "°") return "deg";
  if (word == "rad" || word == "radian" || word == "radians") return "rad";
  return "";
}

std::vector<int> numbers_in(std::string_view text) {
  std::vector<int> out;
  for (std::size_t i = 0; i < text.size();) {
    if (!is_digit(text[i])) {
      ++i;
      continue;
    }
    int value = -1;
    std::from_chars(text.data() + i, text.data() + text.size(), value);
    out.push_back(value);
    while (i < text.size() && is_digit(text[i])) ++i;
  }
  return out;
}

void take_unit(const std::string& unit, std::string& common, const std::string& source) {
  if (unit.empty()) return;
  if (!common.empty() && common != unit) {
    throw InputError(source + ": the titles say " + common + " and " + unit +
                     "; save all columns in one unit");
  }
  common = unit;
}

}  // namespace

ColumnTitle column_title(std::string_view text) {
  constexpr int most_electrodes = 4096;
  ColumnTitle title;
  const std::vector<std::string> words = words_of(text);
  const std::vector<int> numbers = numbers_in(text);
  if (numbers.size() == 4 &&
      std::ranges::all_of(numbers, [](int e) { return e >= 0 && e <= most_electrodes; })) {
    title.electrodes = {numbers[0], numbers[1], numbers[2], numbers[3]};
  }
  for (const std::string& word : words) {
    if (const auto kind = kind_of(word)) title.kind = *kind;
  }
  // A unit stands behind the electrodes: the letter of "V1_2_V3_4" is none.
  const std::size_t last_digit = text.find_last_of("0123456789");
  if (last_digit != std::string_view::npos) {
    for (const std::string& word : words_of(text.substr(last_digit + 1))) {
      if (const std::string unit = unit_of(word); !unit.empty()) title.unit = unit;
    }
  }
  const bool named = !words.empty() && is_stamp(words.front());
  if (named && (numbers.empty() || words.front() == "unnamed")) title.kind = Kind::stamp;
  return title;
}

TitledColumns titled_columns(const std::vector<std::string_view>& titles,
                             const std::string& source) {
  TitledColumns out;
  std::vector<ColumnTitle> read;
  for (const std::string_view text : titles) read.push_back(column_title(text));
  const bool has_channels = std::ranges::any_of(
      read, [](const ColumnTitle& title) { return title.electrodes.has_value(); });
  std::map<std::array<int, 4>, std::size_t> places;
  for (std::size_t c = 0; c < read.size(); ++c) {
    const ColumnTitle& title = read[c];
    const bool is_value = title.kind != Kind::phase && title.kind != Kind::imaginary;
    const bool is_stamp = title.kind == Kind::stamp || (c == 0 && titles[c].empty());
    if (is_stamp || (has_channels && (!title.electrodes || !is_value))) continue;
    if (!has_channels) {
      out.columns.push_back({c, std::nullopt});
      continue;
    }
    const auto [place, is_new] = places.emplace(*title.electrodes, out.columns.size());
    if (!is_new) {
      // Of a magnitude and a real part the latter has the sign.
      TitledColumns::Column& other = out.columns[place->second];
      const std::array kinds = {read[other.value].kind, title.kind};
      if (kinds == std::array{Kind::magnitude, Kind::real}) other.value = c;
      if (kinds[0] != kinds[1] && kinds[0] != Kind::value && kinds[1] != Kind::value) continue;
      throw InputError(source + ": column " + std::to_string(c + 1) +
                       ": the titles name the channel " + joined(*title.electrodes, " ") +
                       " twice; keep one column of it");
    }
    out.columns.push_back({c, std::nullopt});
    out.channels.push_back(*title.electrodes);
    take_unit(title.unit, out.unit, source);
  }
  for (std::size_t c = 0; c < read.size(); ++c) {
    if (read[c].kind != Kind::phase || !read[c].electrodes) continue;
    const auto place = places.find(*read[c].electrodes);
    if (place == places.end()) continue;
    TitledColumns::Column& column = out.columns[place->second];
    if (read[column.value].kind == Kind::real) continue;
    column.phase = c;
    take_unit(read[c].unit, out.phase_unit, source);
  }
  // Electrodes are counted from 1 unless one is called 0.
  const bool from_0 = std::ranges::any_of(out.channels, [](const std::array<int, 4>& channel) {
    return std::ranges::find(channel, 0) != channel.end();
  });
  for (std::array<int, 4>& channel : out.channels) {
    for (int& electrode : channel) electrode -= from_0 ? 0 : 1;
  }
  return out;
}

}  // namespace ertbench
