#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace ertbench {

/// Version of what the records of accuracy and timing hold; part of their keys.
inline constexpr int record_schema = 4;

/// The record of a job in a result folder: `folder`/records/tsvd.accuracy.json, where
/// "tsvd.accuracy" is the job's name. Its log and its progress stand beside it under other endings.
std::filesystem::path record_file(const std::filesystem::path& folder, const std::string& job,
                                  const std::string& ending = ".json");

/// Puts the key, a hash of all that determines the record, into the record and writes it: aside
/// first, then renamed into place.
void write_record(const std::filesystem::path& file, nlohmann::json record, const std::string& key);

/// Nothing where there is no such file, where it is damaged, or where its key is another: then the
/// job is to be done again.
std::optional<nlohmann::json> read_record(const std::filesystem::path& file,
                                          const std::string& key);

}  // namespace ertbench
