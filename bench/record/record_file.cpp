#include "bench/record/record_file.h"

#include <nlohmann/json.hpp>

#include "bench/record/provenance.h"
#include "core/atomic_file.h"
#include "core/build.h"
#include "core/json_checksum.h"
#include "core/json_reader.h"

namespace ertbench {

using nlohmann::json;
namespace fs = std::filesystem;

fs::path record_file(const fs::path& folder, const std::string& job, const std::string& ending) {
  return folder / "records" / (job + ending);
}

BuildStamp stamp_of_records(std::span<const fs::path> plugins) {
  return stamp_of_this_build(this_build().record_code, plugins);
}

void write_record(const fs::path& file, json record, const std::string& key,
                  const BuildStamp& build) {
  record["key"] = key;
  record["build"] = to_json(build);
  record["date"] = utc_now();
  add_checksum(record);
  write_file_atomically(file, json_text(record));
}

FoundRecord find_record(const fs::path& file, const std::string& key, const BuildStamp& now,
                        Reuse reuse) {
  if (!fs::exists(file)) return {};
  try {
    json record = read_json_file(file, most_record_bytes);
    if (const std::string changed = take_checksum(record); !changed.empty()) {
      return {JsonValue(), changed};
    }
    if (record.at("key") != key) return {JsonValue(), "it is of other settings"};
    std::string why = why_stale(build_stamp_from_json(record.value("build", json())), now, reuse);
    if (why.empty() && record.contains("fit_build")) {
      const std::optional<BuildStamp> fitted = build_stamp_from_json(record.at("fit_build"));
      BuildStamp fits = now;
      fits.code = fitted ? fit_code_now(fitted->code) : "";
      why = why_stale(fitted, fits, reuse);
      if (!why.empty()) why = "of its fitted solver: " + why;
    }
    if (!why.empty()) return {JsonValue(), why};
    return {JsonValue(std::move(record)), ""};
  } catch (const std::exception& error) {
    return {JsonValue(), std::string("it cannot be read: ") + error.what()};
  }
}

}  // namespace ertbench
