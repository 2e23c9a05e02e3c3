#include "bench/experiment/experiment_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/experiment/overrides.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "core/text.h"
#include "forward/sheet/sensor_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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
  if (std::any_of(files.begin(), files.end(), is_the_same)) {
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
