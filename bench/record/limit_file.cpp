#include "bench/record/limit_file.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/build_stamp.h"
#include "core/json_reader.h"
#include "core/text.h"

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

std::string limit_key(const DatasetSpec& spec) {
  nlohmann::json set = to_json(spec);
  set.erase("count");
  return hash_of(set.dump());
}

void add_limit_rows(const std::filesystem::path& folder, std::span<const DatasetSpec> tests,
                    std::vector<ResultRow>& rows) {
  for (const ResultRow& limit : read_limit_rows(folder)) {
    const auto test = std::find_if(tests.begin(), tests.end(), [&](const DatasetSpec& spec) {
      return spec.name == limit.dataset && limit.parameters->value("set", "") == limit_key(spec);
    });
    if (test == tests.end()) {
      spdlog::warn("{}: the limit of \"{}\" is of another set; run `ertbench limit` again",
                   (folder / limit_file).string(), printable(limit.dataset));
      continue;
    }
    const auto last = std::find_if(rows.rbegin(), rows.rend(), [&](const ResultRow& row) {
      return row.dataset == limit.dataset &&
             (row.type == "truth" || row.type == "no-contact" || is_limit(row));
    });
    rows.insert(last.base(), limit);
  }
}

std::optional<double> over_limit(const ResultRow& row, std::span<const ResultRow> rows,
                                 Metric metric) {
  const ResultRow* limit = limit_of(rows, row.dataset);
  if (!limit || is_limit(row) || row.type == "truth") return std::nullopt;
  const std::optional<double>& least = limit->metrics[metric].mean;
  const std::optional<double>& mean = row.metrics[metric].mean;
  if (!least || !mean || !(*least > 0)) return std::nullopt;
  return *mean / *least;
}

const ResultRow* limit_of(std::span<const ResultRow> rows, const std::string& dataset) {
  for (const ResultRow& row : rows) {
    if (row.type == limit_oracle && row.dataset == dataset) return &row;
  }
  return nullptr;
}

}  // namespace ertbench
