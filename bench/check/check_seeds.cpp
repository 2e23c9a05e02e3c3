#include "bench/check/check_seeds.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/charts/chart_types.h"
#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "core/json_reader.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The entry with `count` seeds or more: its own, then the smallest that are left.
json with_seeds(json entry, int count) {
  json seeds = entry.contains("seeds") ? entry.at("seeds") : json::array();
  if (entry.contains("seed")) seeds.push_back(entry.at("seed"));
  for (int seed = 1; seeds.size() < static_cast<std::size_t>(count); ++seed) {
    if (std::find(seeds.begin(), seeds.end(), seed) == seeds.end()) seeds.push_back(seed);
  }
  entry.erase("seed");
  entry["seeds"] = std::move(seeds);
  return entry;
}

/// Whether the entry, which may be a sweep, makes a row of one of the labels.
bool makes_row(const Experiment& experiment, std::size_t entry,
               const std::set<std::string>& labels) {
  const std::string path = "/solvers/" + std::to_string(entry);
  return std::any_of(
      experiment.solvers.begin(), experiment.solvers.end(),
      [&](const SolverEntry& one) { return one.path == path && labels.count(one.label) > 0; });
}

/// The times stay those of the experiment's own run.
void take_over_seeds(const ResultRow& trained, ResultRow& row) {
  row.metrics = trained.metrics;
  row.seeds = trained.seeds;
  if (trained.ok()) return;
  row.status = trained.status;
  row.message = trained.message;
}

}  // namespace

std::vector<std::string> overrides_for_seeds(const Experiment& experiment,
                                             const std::set<std::string>& labels, int count) {
  const ExperimentJson read = read_experiment_json(experiment.file, experiment.overrides);
  const json& entries = read.content->at("solvers");
  json solvers = json::array();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (makes_row(experiment, i, labels)) solvers.push_back(with_seeds(entries[i], count));
  }
  std::vector<std::string> out = experiment.overrides;
  out.push_back("solvers=" + solvers.dump());
  out.emplace_back("timing.enabled=false");
  out.emplace_back("figure.scenes=[]");
  // What is made of all rows, and takes long.
  for (const char* key : {"studies", "charts", "ladders", "folds", "right_sizing"}) {
    if (read.content->contains(key)) out.push_back(std::string(key) + "=null");
  }
  return out;
}

int train_over_seeds(const Experiment& experiment, const std::set<std::string>& labels, int count,
                     const Cache& cache, const RunOptions& options, std::vector<ResultRow>& rows) {
  std::set<std::string> few;
  for (const ResultRow& row : rows) {
    const bool enough = row.seeds && std::ssize(row.seeds->values) >= count;
    if (labels.count(row.label) > 0 && !enough) few.insert(row.label);
  }
  if (few.empty()) return 0;
  RunOptions seeds = options;
  seeds.out = options.out / "seeds";
  fs::create_directories(seeds.out);
  SolverRegistry registry;  // into which no plugin has been loaded yet
  const Experiment again =
      read_experiment(experiment.file, registry, chart_types(), SolverCheck::all,
                      overrides_for_seeds(experiment, few, count));
  const ExperimentResults results = run_experiment(again, cache, seeds);
  report_experiment(again, cache, results, seeds.out);
  for (const ResultRow& trained : read_summary_rows(seeds.out)) {
    for (ResultRow& row : rows) {
      if (few.count(row.label) > 0 && row.label == trained.label && row.dataset == trained.dataset)
        take_over_seeds(trained, row);
    }
  }
  return results.failures;
}

std::vector<ResultRow> read_summary_rows(const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  const json summary = read_json_file(file);
  JsonObject root(summary, file.string(), "");
  std::vector<ResultRow> rows;
  for (const JsonObject& row : root.objects("rows")) rows.push_back(result_row_from_json(row));
  return rows;
}

}  // namespace ertbench
