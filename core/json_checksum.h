#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace ertbench {

/// Adds "checksum", the hash of all else in the object.
void add_checksum(nlohmann::json& object);

/// Takes the checksum out again. Why the object is not what was written: "it has no checksum", "it
/// has been changed since it was written"; empty where it is.
std::string take_checksum(nlohmann::json& object);

}  // namespace ertbench
