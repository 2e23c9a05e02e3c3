#include "bench/check/check_trainings.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/check/tolerance.h"
#include "bench/experiment/experiment.h"
#include "bench/run/runner.h"
#include "core/atomic_file.h"
#include "core/json_text.h"
#include "core/replace_file.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

const std::string trained = "trained ";  ///< begins the name of each row

}  // namespace

std::vector<StoredImages> short_trainings(const fs::path& folder,
                                          const std::set<std::string>& types, const Cache& cache,
                                          const fs::path& out, int jobs) {
  const fs::path file = folder / "experiment.json";
  if (!fs::exists(file)) return {};
  SolverRegistry registry;
  const Experiment experiment = read_experiment(file, registry, {});
  RunOptions options;
  options.out = out;
  options.jobs = jobs;
  std::vector<StoredImages> trainings;
  for (const SolverEntry& entry : experiment.solvers) {
    if (types.count(entry.type) == 0) continue;
    options.only.push_back(entry.label);
    const fs::path spec = out / (entry.label + ".json");
    trainings.push_back({trained + entry.label, spec, cache.dataset(experiment.tests.front()),
                         folder / (entry.label + ".images.h5"), out / (entry.label + ".images.h5"),
                         out / (entry.label + ".log"), short_training_tolerance});
    const nlohmann::json solver = {
        {"type", entry.type},
        {"checkpoint", fs::absolute(cache.fitted_solver(fit_recipe(experiment, entry))).string()}};
    fs::create_directories(out);
    write_file_atomically(spec, json_text(solver) + "\n");
  }
  if (trainings.empty()) return {};
  run_experiment(experiment, cache, options);
  std::for_each(trainings.begin(), trainings.end(), make_images);
  return trainings;
}

std::vector<CheckLine> compare_trainings(const std::vector<StoredImages>& trainings,
                                         const std::vector<std::string>& expected) {
  std::vector<CheckLine> lines;
  std::transform(trainings.begin(), trainings.end(), std::back_inserter(lines), compare_images);
  std::vector<std::string> rows;
  for (const std::string& label : expected) rows.push_back(trained + label);
  add_missing_images(rows, lines);
  return lines;
}

std::vector<std::string> labels_of(const std::vector<StoredImages>& trainings) {
  std::vector<std::string> labels;
  for (const StoredImages& one : trainings) labels.push_back(one.row.substr(trained.size()));
  return labels;
}

bool store_trainings(const std::vector<StoredImages>& trainings) {
  const bool all = std::all_of(trainings.begin(), trainings.end(),
                               [](const StoredImages& one) { return fs::exists(one.now); });
  if (!all) return false;
  for (const StoredImages& one : trainings) {
    replace_file(one.before, [&](const fs::path& aside) { fs::copy_file(one.now, aside); });
  }
  return true;
}

}  // namespace ertbench
