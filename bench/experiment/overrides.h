#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace ertbench {

/// Puts values from the command line into the content of an experiment file, one after another:
/// `datasets.test.count=200`, `solvers.0.lambda=auto`. The words of the path are keys of objects
/// and indices of arrays, with dots between them; a path that begins with "/" is a JSON pointer
/// (RFC 6901), for keys with dots in them. What stands behind the first "=" is JSON, or, where it
/// is none, a string. The last key may be new, as many settings have defaults, but for that of a
/// dataset; whether there is such a setting the reader of the file finds out. null takes a key of
/// the file's root away. Throws InputError naming the override, and the nearest key where the path
/// leads nowhere.
void apply_overrides(nlohmann::json& content, const std::vector<std::string>& overrides);

}  // namespace ertbench
