#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/json.h"

namespace ertbench {

/// Whether it may name a dataset or a chart, whose names become parts of file names: it must be
/// made of letters, digits, "_" and "-", at most 60 of them.
bool is_name(std::string_view text);

/// Whether it may label a solver: it must be made of letters, digits, spaces and any of . _ + = , -
/// (at most 60), with no dot at the start and no spaces at the ends. Labels become file names too.
bool is_label(std::string_view text);

/// Whether every character may stand in a label.
bool is_label_text(std::string_view text);

/// Puts values from the command line into the content of an experiment file, one after another:
/// `datasets.test.count=200`, `solvers.0.lambda=auto`. The words of the path are keys of objects
/// and indices of arrays, with dots between them; a path that begins with "/" is a JSON pointer
/// (RFC 6901), for keys with dots in them. What stands behind the first "=" is JSON, or, where it
/// is none, a string. The last key may be new, as many settings have defaults, but for that of a
/// dataset; whether there is such a setting the reader of the file finds out. null takes a key of
/// the file's root away. Throws InputError naming the override, and the nearest key where the path
/// leads nowhere.
void apply_overrides(nlohmann::json& content, const std::vector<std::string>& overrides);

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

/// The text of a schema's file, of experiments or of sensors, with the types, ranges and defaults
/// that the program has now. Descriptions stay as they are, and so does all that is no field of a
/// struct (Fields). Throws InputError for what read_json_file refuses.
std::string updated_schema(const std::filesystem::path& file);

}  // namespace ertbench
