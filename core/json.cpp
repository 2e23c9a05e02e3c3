#include "core/json.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/files.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {

using nlohmann::json;

JsonValue::JsonValue(json value) : value_(std::make_shared<const json>(std::move(value))) {}

JsonValue JsonValue::object() { return json::object(); }

JsonValue JsonValue::array() { return json::array(); }

const json& JsonValue::operator*() const {
  static const json null;
  return value_ ? *value_ : null;
}

JsonValue::operator bool() const { return !(*this)->is_null(); }

std::string JsonValue::text() const { return *this ? json_text(**this) : ""; }

bool operator==(const JsonValue& a, const JsonValue& b) { return *a == *b; }

namespace {

std::string size_text(std::uint64_t bytes) {
  const auto size = static_cast<double>(bytes);
  const bool large = bytes >= std::uint64_t{1} << 30U;
  char text[64];
  std::snprintf(text, sizeof text, large ? "%.3g GB" : "%.3g MB",
                size / (large ? 1073741824.0 : 1048576.0));
  return text;
}

/// Counts brackets outside strings.
bool is_nested_deeper(std::string_view text, int most) {
  int level = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        in_string = false;
      }
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++level > most) return true;
    } else if (c == ']' || c == '}') {
      --level;
    }
  }
  return false;
}

/// The library's message without its own prefix and error number.
std::string words_of(const json::exception& error) {
  const std::string what = error.what();
  const auto start = what.find("] ");
  return printable(start == std::string::npos ? what : what.substr(start + 2));
}

/// Longest text, such as a title or a label, which messages, tables and pages repeat.
constexpr std::size_t most_text = 4000;

/// JSON path segment: "~" and "/" are escaped as in RFC 6901.
std::string escaped(std::string_view key) {
  std::string out;
  for (const char c : printable(key)) {
    if (c == '~') {
      out += "~0";
    } else if (c == '/') {
      out += "~1";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

void require_json_size(std::uint64_t bytes, const std::string& source, std::uint64_t most_bytes) {
  if (bytes <= most_bytes) return;
  throw InputError(source + ": is " + size_text(bytes) + " of JSON, more than " +
                   size_text(most_bytes) + "; check that it is the right one");
}

json parse_json(std::string_view text, const std::string& source, std::uint64_t most_bytes) {
  require_json_size(text.size(), source, most_bytes);
  if (is_nested_deeper(text, most_json_levels)) {
    throw InputError(source + ": is nested deeper than " + std::to_string(most_json_levels) +
                     " arrays and objects; check that it is the right one");
  }
  std::vector<std::set<std::string>> keys;  // one set for each open object
  std::optional<std::string> twice;
  const auto watch = [&](int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) {
      keys.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      keys.pop_back();
    } else if (event == json::parse_event_t::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!keys.back().insert(key).second && !twice) twice = key;
    }
    return true;
  };
  json value;
  try {
    value = json::parse(text, watch);
  } catch (const json::exception& error) {
    throw InputError(source + ": not valid JSON: " + words_of(error));
  }
  if (twice) {
    throw InputError(source + ": the key \"" + printable(*twice) +
                     "\" stands twice in one object; remove one");
  }
  return value;
}

std::string json_text(const json& value, int indent) {
  return value.dump(indent, ' ', false, json::error_handler_t::replace);
}

std::string json_shown(const json& value) { return printable(json_text(value), 60); }

json printable_json(const json& value, std::size_t most) {
  if (value.is_string()) return printable(value.get_ref<const std::string&>(), most);
  if (!value.is_structured()) return value;
  json out = value.is_array() ? json::array() : json::object();
  for (const auto& [key, one] : value.items()) {
    if (value.is_array()) {
      out.push_back(printable_json(one, most));
    } else {
      out[printable(key, most)] = printable_json(one, most);
    }
  }
  return out;
}

json read_json_file(const std::filesystem::path& file, std::uint64_t most_bytes) {
  const std::string name = file.string();
  require_regular_file(file);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error) require_json_size(size, name, most_bytes);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(name + ": cannot be opened; check the name and the permissions");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return parse_json(text, name, most_bytes);
}

std::string Range::text() const {
  const bool below = std::isfinite(low);
  const bool above = std::isfinite(high);
  const std::string of = *unit ? std::string(" ") + unit : "";
  if (below && above) {
    return (low_open ? "must be > " + number_text(low) + " and <= "
                     : "must be from " + number_text(low) + " to ") +
           number_text(high) + of;
  }
  if (below) return (low_open ? "must be > " : "must be >= ") + number_text(low) + of;
  if (above) return "must be <= " + number_text(high) + of;
  return "must be a number";
}

JsonError::JsonError(const std::string& source, std::string path, std::string message)
    : InputError((source.empty() ? "" : source + ": ") + (path.empty() ? "/" : path) + ": " +
                 message),
      path_(std::move(path)),
      message_(std::move(message)) {}

std::filesystem::path folder_of_source(const std::string& source) {
  const std::filesystem::path file = source.substr(0, source.find(extends_mark));
  return std::filesystem::absolute(file).parent_path().lexically_normal();
}

std::filesystem::path JsonObject::folder() const { return folder_of_source(source_); }

JsonObject::JsonObject(const json& value, std::string source, std::string path)
    : value_(&value), source_(std::move(source)), path_(std::move(path)) {
  if (!value.is_object()) fail("", "must be an object, got " + json_shown(value));
}

std::string JsonObject::path_of(std::string_view key) const {
  return key.empty() ? path_ : path_ + "/" + escaped(key);
}

void JsonObject::fail(std::string_view key, const std::string& message) const {
  throw JsonError(source_, path_of(key), message);
}

bool JsonObject::has(std::string_view key) const {
  note(key);
  return value_->contains(key);
}

const json& JsonObject::raw(std::string_view key) {
  note(key);
  const auto found = value_->find(key);
  if (found == value_->end()) fail(key, "is missing");
  return *found;
}

double JsonObject::number(std::string_view key, Range range) {
  const json& v = raw(key);
  if (!v.is_number() || !range.contains(v.get<double>())) {
    fail(key, range.text() + ", got " + json_shown(v));
  }
  return v.get<double>();
}

double JsonObject::number_or(std::string_view key, double fallback, Range range) {
  return has(key) ? number(key, range) : fallback;
}

int JsonObject::integer(std::string_view key, int low, int high) {
  const json& v = raw(key);
  const bool whole = v.is_number() && v.get<double>() == std::floor(v.get<double>());
  if (!whole || v.get<double>() < low || v.get<double>() > high) {
    fail(key, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high) +
                  ", got " + json_shown(v));
  }
  return static_cast<int>(v.get<double>());
}

int JsonObject::integer_or(std::string_view key, int fallback, int low, int high) {
  return has(key) ? integer(key, low, high) : fallback;
}

bool JsonObject::boolean_or(std::string_view key, bool fallback) {
  if (!has(key)) return fallback;
  const json& v = raw(key);
  if (!v.is_boolean()) fail(key, "must be true or false, got " + json_shown(v));
  return v.get<bool>();
}

std::string JsonObject::text(std::string_view key) {
  const json& v = raw(key);
  if (!v.is_string() || v.get_ref<const std::string&>().empty()) {
    fail(key, "must be a string that is not empty, got " + json_shown(v));
  }
  if (v.get_ref<const std::string&>().size() > most_text) {
    fail(key,
         "must be at most " + std::to_string(most_text) + " bytes of text, got " + json_shown(v));
  }
  return v.get<std::string>();
}

std::string JsonObject::text_or(std::string_view key, std::string_view fallback) {
  return has(key) ? text(key) : std::string(fallback);
}

std::string JsonObject::choice(std::string_view key, const std::vector<std::string>& choices) {
  const json& v = raw(key);
  if (!v.is_string() ||
      std::find(choices.begin(), choices.end(), v.get<std::string>()) == choices.end()) {
    std::string list;
    for (const auto& c : choices) list += (list.empty() ? "\"" : ", \"") + c + "\"";
    fail(key, "must be one of " + list + ", got " + json_shown(v));
  }
  return v.get<std::string>();
}

std::string JsonObject::choice_or(std::string_view key, std::string_view fallback,
                                  const std::vector<std::string>& choices) {
  return has(key) ? choice(key, choices) : std::string(fallback);
}

std::pair<double, double> JsonObject::interval(std::string_view key, Range range) {
  const json& v = raw(key);
  if (v.is_number()) {
    const double x = number(key, range);
    return {x, x};
  }
  const std::vector<double> ends = numbers(key, 2, range);
  if (ends[0] > ends[1]) fail(key, "must be [low, high] with low <= high, got " + json_shown(v));
  return {ends[0], ends[1]};
}

std::pair<int, int> JsonObject::integer_interval(std::string_view key, int low, int high) {
  const json& v = raw(key);
  if (v.is_number()) {
    const int x = integer(key, low, high);
    return {x, x};
  }
  const auto [first, last] = interval(key, {double(low), double(high)});
  if (first != std::floor(first) || last != std::floor(last)) {
    fail(key, "must be whole numbers, got " + json_shown(v));
  }
  return {static_cast<int>(first), static_cast<int>(last)};
}

std::vector<double> JsonObject::numbers(std::string_view key, std::size_t size, Range range) {
  const json& v = raw(key);
  if (!v.is_array() || v.size() != size ||
      !std::all_of(v.begin(), v.end(), [](const json& x) { return x.is_number(); })) {
    fail(key, "must be an array of " + std::to_string(size) + " numbers, got " + json_shown(v));
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (!range.contains(v[i].get<double>())) {
      fail(std::string(key),
           "element " + std::to_string(i) + " " + range.text() + ", got " + json_shown(v[i]));
    }
  }
  return v.get<std::vector<double>>();
}

std::vector<std::string> JsonObject::choices(std::string_view key,
                                             const std::vector<std::string>& choices) {
  const json& v = raw(key);
  const std::string wanted = "must be a list of any of " + json(choices).dump();
  if (!v.is_array() || v.empty()) fail(key, wanted + ", got " + json_shown(v));
  std::vector<std::string> out;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const json one = {{std::to_string(i), v[i]}};
    out.push_back(JsonObject(one, source_, path_of(key)).choice(std::to_string(i), choices));
  }
  return out;
}

std::vector<std::array<double, 2>> JsonObject::points(std::string_view key, std::size_t least,
                                                      std::size_t most, Range range) {
  const json& v = raw(key);
  if (!v.is_array() || v.size() < least || v.size() > most) {
    fail(key, "must be a list of " + std::to_string(least) + " to " + std::to_string(most) +
                  " points [x, y]");
  }
  std::vector<std::array<double, 2>> out;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const json one = {{std::to_string(i), v[i]}};
    const std::vector<double> xy =
        JsonObject(one, source_, path_of(key)).numbers(std::to_string(i), 2, range);
    out.push_back({xy[0], xy[1]});
  }
  return out;
}

std::vector<int> JsonObject::integers(std::string_view key, std::size_t least, std::size_t most,
                                      std::pair<int, int> range) {
  const json& v = raw(key);
  const auto fits = [&](const json& x) {
    return x.is_number_integer() && x >= range.first && x <= range.second;
  };
  if (!v.is_array() || v.size() < least || v.size() > most ||
      !std::all_of(v.begin(), v.end(), fits)) {
    fail(key, "must be an array of " + std::to_string(least) +
                  (most == least ? "" : " to " + std::to_string(most)) + " whole numbers from " +
                  std::to_string(range.first) + " to " + std::to_string(range.second) + ", got " +
                  json_shown(v));
  }
  return v.get<std::vector<int>>();
}

JsonObject JsonObject::object(std::string_view key) {
  return JsonObject(raw(key), source_, path_of(key));
}

std::vector<JsonObject> JsonObject::objects(std::string_view key) {
  const json& v = raw(key);
  if (!v.is_array()) fail(key, "must be an array of objects, got " + json_shown(v));
  std::vector<JsonObject> out;
  for (std::size_t i = 0; i < v.size(); ++i) {
    out.emplace_back(v[i], source_, path_of(key) + "/" + std::to_string(i));
  }
  return out;
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> out;
  for (const auto& [key, unused] : value_->items()) out.push_back(key);
  return out;
}

void JsonObject::finish() const {
  for (const auto& key : keys()) {
    if (known_.count(key)) continue;
    const std::vector<std::string> known(known_.begin(), known_.end());
    const std::string near = nearest_word(key, known);
    fail(key, near.empty() ? "unknown key; known here: " + joined(known)
                           : "unknown key; did you mean \"" + near + "\"?");
  }
}

}  // namespace ertbench
