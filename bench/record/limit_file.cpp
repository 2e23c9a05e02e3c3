#include "bench/record/limit_file.h"

#include <nlohmann/json.hpp>

#include "core/json_reader.h"

namespace ertbench {

bool is_limit(const ResultRow& row) { return row.type == limit_oracle || row.type == limit_fair; }

std::vector<ResultRow> read_limit_rows(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / limit_file;
  if (!std::filesystem::exists(file)) return {};
  const nlohmann::json json = read_json_file(file);
  JsonObject root(json, file.string(), "");
  std::vector<ResultRow> rows;
  for (const JsonObject& row : root.objects("rows")) {
    rows.push_back(result_row_from_json(row));
    if (!is_limit(rows.back())) root.fail("rows", "must be of the types of limits");
  }
  return rows;
}

const ResultRow* limit_of(std::span<const ResultRow> rows, const std::string& dataset) {
  for (const ResultRow& row : rows) {
    if (row.type == limit_oracle && row.dataset == dataset) return &row;
  }
  return nullptr;
}

}  // namespace ertbench
