#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/json.h"

namespace ertbench {

/// True for a valid name of a dataset or chart, which becomes part of file names: 1 to 60 letters,
/// digits, "_" and "-".
bool is_name(std::string_view text);

/// True for a valid label of a solver, which becomes a file name: at most 60 letters, digits,
/// spaces and . _ + = , - without a dot at the start or spaces at the ends.
bool is_label(std::string_view text);

/// True if every character is valid in a label.
bool is_label_text(std::string_view text);

/// Applies overrides from the command line to the content of an experiment file, one after another:
/// `datasets.test.count=200`, `solvers.0.lambda=auto`. The path consists of keys of objects and
/// indices of arrays, separated by dots; a path that begins with "/" is a JSON pointer (RFC 6901),
/// for keys that contain dots. The text after the first "=" is JSON, or else a string. The last key
/// may be new, because many settings have defaults; the reader of the file refuses unknown ones. A
/// new dataset is refused. null removes a key of the root. Throws InputError naming the override,
/// and the nearest key if the path leads nowhere.
void apply_overrides(nlohmann::json& content, const std::vector<std::string>& overrides);

/// The merged content of an experiment file and of the files that it extends.
struct ExperimentJson {
  JsonValue content;   ///< without "extends"
  std::string source;  ///< for messages: "noisy.json (extends localisation.json)"
  std::vector<std::filesystem::path> files;  ///< all files read, the experiment's own first
};

/// Reads the JSON of an experiment file; no other function does. A file with `"extends":
/// "localisation.json"`, relative to itself, is that file's content with its own keys merged into
/// it (JSON merge patch, RFC 7386: objects key by key, all else whole, null removes). That file may
/// extend another. `overrides` are applied last (apply_overrides). Throws InputError for what
/// read_json_file refuses, for circles and for chains that are too long.
ExperimentJson read_experiment_json(const std::filesystem::path& file,
                                    const std::vector<std::string>& overrides = {});

/// The text of a schema's file, of experiments or of sensors, with the types, ranges and defaults
/// that the program has now. Descriptions stay as they are, and so does all that is no field of a
/// struct (Fields). Throws InputError for what read_json_file refuses.
std::string updated_schema(const std::filesystem::path& file);

}  // namespace ertbench
