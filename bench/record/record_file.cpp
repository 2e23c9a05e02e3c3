#include "bench/record/record_file.h"

#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/json_reader.h"

namespace ertbench {

using nlohmann::json;
namespace fs = std::filesystem;

fs::path record_file(const fs::path& folder, const std::string& job, const std::string& ending) {
  return folder / "records" / (job + ending);
}

void write_record(const fs::path& file, json record, const std::string& key) {
  record["key"] = key;
  write_file_atomically(file, record.dump());
}

std::optional<json> read_record(const fs::path& file, const std::string& key) {
  if (!fs::exists(file)) return std::nullopt;
  try {
    json record = read_json_file(file);
    if (record.at("key") == key) return record;
  } catch (const std::exception&) {  // not a record of ours: made again
  }
  return std::nullopt;
}

}  // namespace ertbench
