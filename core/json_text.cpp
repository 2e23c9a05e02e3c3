#include "core/json_text.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::string size_text(std::uint64_t bytes) {
  const auto size = static_cast<double>(bytes);
  const bool large = bytes >= std::uint64_t{1} << 30U;
  char text[64];
  std::snprintf(text, sizeof text, large ? "%.3g GB" : "%.3g MB",
                size / (large ? 1073741824.0 : 1048576.0));
  return text;
}

/// Counted in the text, where brackets within strings are none.
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

/// What the library says, without its own name and number of the error.
std::string words_of(const json::exception& error) {
  const std::string what = error.what();
  const auto start = what.find("] ");
  return printable(start == std::string::npos ? what : what.substr(start + 2));
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

}  // namespace ertbench
