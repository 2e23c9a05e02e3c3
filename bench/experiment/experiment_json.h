#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/json_value.h"

namespace ertbench {

/// What stands in an experiment file and in those that it extends.
struct ExperimentJson {
  JsonValue content;   ///< without "extends"
  std::string source;  ///< for messages: "noisy.json (extends localisation.json)"
  std::vector<std::filesystem::path> files;  ///< that were read, the experiment's own first
};

/// The only way to an experiment file's JSON. A file with `"extends": "localisation.json"`
/// (relative to itself) is that file's content with its own keys merged into it (JSON merge patch,
/// RFC 7386: objects key by key, arrays and all else whole, null removes); that file may extend
/// another. `overrides` (apply_overrides) come last. Throws InputError for what read_json_file
/// refuses, for circles and for chains that are too long.
ExperimentJson read_experiment_json(const std::filesystem::path& file,
                                    const std::vector<std::string>& overrides = {});

}  // namespace ertbench
