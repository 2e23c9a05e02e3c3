#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "bench/record/reuse.h"
#include "core/json_value.h"

namespace ertbench {

/// Version of what the records of accuracy and timing hold; part of their keys.
inline constexpr int record_schema = 4;

/// The record of a job in a result folder: `folder`/records/tsvd.accuracy.json, where
/// "tsvd.accuracy" is the job's name. Its log and its progress stand beside it under other endings.
std::filesystem::path record_file(const std::filesystem::path& folder, const std::string& job,
                                  const std::string& ending = ".json");

/// Of the file in which a job's process leaves its record; the runner renames it when that has
/// ended well, as what a process wrote that crashed afterwards is not to be trusted.
inline constexpr const char* written_ending = ".written.json";

/// Of the file in which a job's process says how it failed, where it knows: `{"status",
/// "message"}`.
inline constexpr const char* failure_ending = ".failure.json";

/// The build of the records that this program writes.
BuildStamp stamp_of_records(std::span<const std::filesystem::path> plugins);

/// Puts the key, a hash of all that determines the record, the build and the date into the record
/// and writes it: aside first, then renamed into place.
void write_record(const std::filesystem::path& file, nlohmann::json record, const std::string& key,
                  const BuildStamp& build);

/// What stands in a record's place.
struct FoundRecord {
  JsonValue record;     ///< null: the job is to be done again
  std::string why_not;  ///< why not what is there; empty where there is nothing
};

/// The record of that key, where it may be reused: its "build" is what made it, its "fit_build",
/// where it has one, what fitted the solver.
FoundRecord find_record(const std::filesystem::path& file, const std::string& key,
                        const BuildStamp& now, Reuse reuse);

}  // namespace ertbench
