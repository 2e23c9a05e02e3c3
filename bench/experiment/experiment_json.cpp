#include "bench/experiment/experiment_json.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/errors.h"
#include "core/lists.h"
#include "core/text.h"
#include "forward/sheet/sensor_json.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t longest = 60;

bool is_letter_or_digit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

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

Override override_from(const std::string& text) {
  Override out;
  out.text = text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    out.fail("must be PATH=VALUE, as in datasets.test.count=200");
  }
  const std::string path = text.substr(0, equals);
  if (path[0] == '/') {
    for (const std::string& part : split(path.substr(1), "/")) {  // with escapes of RFC 6901
      out.words.push_back(replaced(replaced(part, "~1", "/"), "~0", "~"));
    }
  } else {
    out.words = split(path, ".");
  }
  const bool empty =
      std::ranges::any_of(out.words, [](const std::string& word) { return word.empty(); });
  if (empty) out.fail("its path has an empty word");
  const std::string value = text.substr(equals + 1);
  try {
    out.value = parse_json(value, "--set");
  } catch (const InputError&) {
    out.value = json(value);
  }
  return out;
}

/// The place of the words before `count`, as it is written: "datasets.test".
std::string place_of(const Override& one, std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += (i == 0 ? "" : ".") + printable(one.words[i]);
  return out.empty() ? "the file" : out;
}

json& element_of(json& array, const Override& one, std::size_t at) {
  const auto index = whole_number<std::size_t>(one.words[at]);
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
  const std::vector<std::string> known = JsonObject(object, "", "").keys();
  const std::string near = nearest_word(word, known);
  // A key that is nearly another is a slip; whether any other one is a setting the reader knows.
  if (!may_be_new(one, at) || (at == 0 && !near.empty())) {
    one.fail(place_of(one, at) + " has no \"" + printable(word) + "\"" +
             (near.empty()
                  ? "; there are " +
                        joined(known, ", ", [](const std::string& key) { return printable(key); })
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

constexpr std::size_t most_extended = 4;  ///< files behind the experiment's own

/// Puts the content of a sensor's file in the place of its name, where `content`, of `file`, names
/// one: files that extend this one may change parts of it. Whether it did.
bool read_named_sensor(json& content, const fs::path& file) {
  if (!content.is_object() || !content.contains("sensor") || !content["sensor"].is_string()) {
    return false;
  }
  JsonObject object(content, file.string(), "");
  const fs::path sensor = [&] {
    try {
      return find_sensor_file(object.text("sensor"), file);
    } catch (const InputError& e) {
      object.fail("sensor", e.what());
    }
  }();
  content["sensor"] = read_sensor_json(sensor);
  return true;
}

/// The content of the last of `files`, whose extended files are put behind it.
json merged_content(std::vector<fs::path>& files) {
  const fs::path file = files.back();
  json own = read_json_file(file);
  const bool other_sensor = read_named_sensor(own, file);
  if (!own.is_object() || !own.contains("extends")) return own;
  JsonObject object(own, file.string(), "");
  const fs::path extended = file.parent_path() / object.text("extends");
  const auto is_the_same = [&](const fs::path& one) {
    std::error_code absent;
    return fs::equivalent(one, extended, absent);
  };
  if (std::ranges::any_of(files, is_the_same)) {
    object.fail("extends", "goes in a circle: " + printable_path(extended.string()) +
                               " is this file or extends it; name another or none");
  }
  if (files.size() > most_extended) {
    object.fail("extends", "is one too many: at most " + std::to_string(most_extended) +
                               " files behind each other; merge some of them");
  }
  files.push_back(extended);
  json merged;
  try {
    merged = merged_content(files);
  } catch (const InputError& e) {
    object.fail("extends", e.what());
  }
  if (!merged.is_object()) {
    object.fail("extends", printable_path(extended.string()) + " is not an experiment");
  }
  own.erase("extends");
  // A sensor that has a file is a whole one: nothing of the extended file's is left in it.
  if (other_sensor) merged.erase("sensor");
  merged.merge_patch(own);
  return merged;
}

/// "noisy.json (extends localisation.json)"; of several the nearest first.
std::string source_of(const std::vector<fs::path>& files) {
  std::string extended;
  for (std::size_t i = 1; i < files.size(); ++i) {
    const fs::path shown =
        files[i].lexically_normal().lexically_proximate(files[0].parent_path().lexically_normal());
    extended += (extended.empty() ? extends_mark : ", ") + printable(shown.string());
  }
  return files[0].string() + extended + (extended.empty() ? "" : ")");
}

}  // namespace

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= longest && std::ranges::all_of(text, [](char c) {
    return is_letter_or_digit(c) || c == '_' || c == '-';
  });
}

bool is_label_text(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    return is_letter_or_digit(c) || std::string_view(" ._+=,-").find(c) != std::string_view::npos;
  });
}

bool is_label(std::string_view text) {
  return !text.empty() && text.size() <= longest && is_label_text(text) && text.front() != '.' &&
         text.front() != ' ' && text.back() != ' ';
}

void apply_overrides(json& content, const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) apply_one(content, override_from(text));
}

ExperimentJson read_experiment_json(const fs::path& file,
                                    const std::vector<std::string>& overrides) {
  ExperimentJson out;
  out.files = {file};
  json content = merged_content(out.files);
  for (const std::string& one : overrides) {
    apply_overrides(content, {one});
    read_named_sensor(content, file);
  }
  out.content = std::move(content);
  out.source = source_of(out.files);
  return out;
}

}  // namespace ertbench
