#include "bench/record/limit_file.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/build.h"
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

std::string limit_key(const DatasetSpec& set, const DatasetSpec& scenes) {
  nlohmann::json key = {{"set", to_json(set)},
                        {"scenes", to_json(scenes).value("scenes", nlohmann::json())}};
  key["set"].erase("count");
  return hash_of(key.dump());
}

namespace {

/// Why a row of limits is not to be shown; empty where it is.
std::string why_not(const ResultRow& limit, const LimitSets& sets, Reuse reuse) {
  const auto test =
      std::find_if(sets.tests.begin(), sets.tests.end(),
                   [&](const DatasetSpec& spec) { return spec.name == limit.dataset; });
  if (test == sets.tests.end()) return "it is of another set";
  const DatasetSpec* scenes = limit.type == limit_oracle ? &*test : sets.training;
  if (!scenes || limit.parameters->value("set", "") != limit_key(*test, *scenes)) {
    return "it is of other scenes";
  }
  const BuildStamp now = stamp_of_this_build(this_build().limit_code);
  if (limit.build.scored.empty()) return why_stale(std::nullopt, now, Reuse::same_code);
  for (const BuildStamp& made : limit.build.scored) {
    // No run computes a limit again: what the same code found in another program stays.
    const std::string why = why_stale(made, now, reuse == Reuse::clean ? reuse : Reuse::same_code);
    if (!why.empty()) return why;
  }
  return "";
}

}  // namespace

void add_limit_rows(const std::filesystem::path& folder, const LimitSets& sets, Reuse reuse,
                    std::vector<ResultRow>& rows) {
  for (const ResultRow& limit : read_limit_rows(folder)) {
    const std::string why = why_not(limit, sets, reuse);
    if (!why.empty()) {
      spdlog::warn("{}: {} of \"{}\" is left out: {}; run `ertbench limit` again",
                   (folder / limit_file).string(), limit.label, printable(limit.dataset), why);
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
