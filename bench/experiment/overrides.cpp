#include "bench/experiment/overrides.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/errors.h"
#include "core/json_text.h"
#include "core/json_value.h"
#include "core/nearest_word.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Settings of the file's root that are objects and have defaults, so that one of them may be set
/// where the file says nothing of the others.
constexpr const char* optional_objects[] = {"timing", "contacts", "check", "figure", "sensor"};

/// One `path=value`.
struct Override {
  std::string text;  ///< as it was given
  std::vector<std::string> words;
  JsonValue value;

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError("--set " + printable(text) + ": " + why);
  }
};

/// Of a part of a JSON pointer: "~1" is "/", "~0" is "~".
std::string unescaped(const std::string& part) {
  std::string out;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const bool escape = part[i] == '~' && i + 1 < part.size();
    if (escape && (part[i + 1] == '0' || part[i + 1] == '1')) {
      out += part[++i] == '0' ? '~' : '/';
    } else {
      out += part[i];
    }
  }
  return out;
}

Override override_from(const std::string& text) {
  Override out;
  out.text = text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    out.fail("must be PATH=VALUE, as in datasets.test.count=200");
  }
  const std::string path = text.substr(0, equals);
  if (path[0] == '/') {
    for (const std::string& part : split(path.substr(1), "/")) {
      out.words.push_back(unescaped(part));
    }
  } else {
    out.words = split(path, ".");
  }
  const bool empty = std::any_of(out.words.begin(), out.words.end(),
                                 [](const std::string& word) { return word.empty(); });
  if (empty) out.fail("its path has an empty word");
  const std::string value = text.substr(equals + 1);
  try {
    out.value = parse_json(value, "--set");
  } catch (const InputError&) {
    out.value = json(value);
  }
  return out;
}

std::vector<std::string> keys_of(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, unused] : object.items()) keys.push_back(key);
  return keys;
}

std::string list_of_words(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + printable(word);
  return out;
}

/// The place of the words before `count`, as it is written: "datasets.test".
std::string place_of(const Override& one, std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += (i == 0 ? "" : ".") + printable(one.words[i]);
  return out.empty() ? "the file" : out;
}

std::optional<std::size_t> index_of(const std::string& word) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return index;
}

json& element_of(json& array, const Override& one, std::size_t at) {
  const auto index = index_of(one.words[at]);
  if (!index || *index >= array.size()) {
    one.fail(place_of(one, at) + " is a list of " + std::to_string(array.size()) +
             "; name one of its values by its number from 0, not \"" + printable(one.words[at]) +
             "\"");
  }
  return array[*index];
}

bool may_be_new(const Override& one, std::size_t at) {
  if (at + 1 == one.words.size()) return at > 0 ? one.words[at - 1] != "datasets" : true;
  return at == 0 && std::find(std::begin(optional_objects), std::end(optional_objects),
                              one.words[0]) != std::end(optional_objects);
}

json& member_of(json& object, const Override& one, std::size_t at) {
  const std::string& word = one.words[at];
  if (object.contains(word)) return object[word];
  const std::vector<std::string> known = keys_of(object);
  const std::string near = nearest_word(word, known);
  // A key that is nearly another is a slip; whether any other one is a setting the reader knows.
  if (!may_be_new(one, at) || (at == 0 && !near.empty())) {
    one.fail(place_of(one, at) + " has no \"" + printable(word) + "\"" +
             (near.empty() ? "; there are " + list_of_words(known)
                           : "; did you mean \"" + printable(near) + "\"?"));
  }
  json& made = object[word];
  if (at + 1 < one.words.size()) made = json::object();
  return made;
}

void apply_one(json& content, const Override& one) {
  if (one.words.size() == 1 && one.value->is_null() && content.is_object()) {
    member_of(content, one, 0);  // refuses a slip
    content.erase(one.words[0]);
    return;
  }
  json* place = &content;
  for (std::size_t at = 0; at < one.words.size(); ++at) {
    if (place->is_array()) {
      place = &element_of(*place, one, at);
    } else if (place->is_object()) {
      place = &member_of(*place, one, at);
    } else {
      one.fail(place_of(one, at) + " is " + json_shown(*place) + " and has nothing inside it");
    }
  }
  *place = *one.value;
}

}  // namespace

void apply_overrides(json& content, const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) apply_one(content, override_from(text));
}

}  // namespace ertbench
