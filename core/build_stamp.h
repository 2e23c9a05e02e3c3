#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ertbench {

/// The build that made a record, a fitted solver or a dataset.
struct BuildStamp {
  std::string commit;                ///< see Build
  bool dirty = false;                ///< whether its sources were not that commit's
  std::string program;               ///< hash of the program, its libraries and the learned solvers
  std::string code;                  ///< hash of the sources that the thing depends on, see Build
  std::vector<std::string> plugins;  ///< hashes of the user's plugins

  bool operator==(const BuildStamp&) const = default;
  std::string commit_text() const;
};

/// Of this program. `code`: one of the hashes in this_build().
BuildStamp stamp_of_this_build(const std::string& code,
                               std::span<const std::filesystem::path> plugins = {});

/// `{"commit", "dirty", "program", "code", "plugins"}`.
nlohmann::json to_json(const BuildStamp& stamp);
/// Nothing where the JSON is no stamp: what earlier versions made has none.
std::optional<BuildStamp> build_stamp_from_json(const nlohmann::json& stamp);

/// 128 bits of `text`, 32 hexadecimal digits (XXH3).
std::string hash_of(const std::string& text);
/// Checksum of a file's contents. Throws InputError if it cannot be read.
std::string hash_of_file(const std::filesystem::path& file);

}  // namespace ertbench
