#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/probe.h"

namespace ertbench {

/// The build that made a record, a fitted solver or a dataset.
struct BuildStamp {
  std::string commit;   ///< see Build
  bool dirty = false;   ///< whether its sources were not that commit's
  std::string program;  ///< hash of the program, its libraries and the learned solvers
  /// The probes that the thing depends on, as that build computed them. Files of release 0.2.0 have
  /// none and count as if they had that release's (release_probes).
  Probes probes;
  std::vector<std::string> plugins;  ///< hashes of the user's plugins

  bool operator==(const BuildStamp& other) const;
  std::string commit_text() const;
};

/// The stamp of what this program makes. `probes`: all that the thing depends on.
BuildStamp stamp_of_this_build(Probes probes = {},
                               std::span<const std::filesystem::path> plugins = {});

/// `{"commit", "dirty", "program", "probes", "plugins"}`, the last two only where there are any.
nlohmann::json to_json(const BuildStamp& stamp);
/// Nothing where the JSON is no stamp: what earlier versions made has none.
std::optional<BuildStamp> build_stamp_from_json(const nlohmann::json& stamp);

/// 128 bits of `text`, 32 hexadecimal digits (XXH3).
std::string hash_of(const std::string& text);
/// Checksum of a file's contents. Throws InputError if it cannot be read.
std::string hash_of_file(const std::filesystem::path& file);

}  // namespace ertbench
