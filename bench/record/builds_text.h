#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/build_stamp.h"

namespace ertbench {

/// By stage, and of "fits": the builds that made the records of a result, each once.
using Builds = std::map<std::string, std::vector<BuildStamp>>;

/// For a table's foot: "build: commit 0123456789ab, program 01234567.", of several builds each with
/// what it made; empty where there is none.
std::string text_of(const Builds& builds);

/// `{"accuracy": [{"commit", ...}], "fits": [...], ...}`
nlohmann::json to_json(const Builds& builds);

}  // namespace ertbench
