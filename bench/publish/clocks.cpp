#include "bench/publish/clocks.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "bench/features/features.h"
#include "bench/publish/clock_stage.h"
#include "bench/publish/published_result.h"
#include "bench/record/record_file.h"
#include "bench/run/job_runner.h"
#include "bench/run/runner.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {

namespace fs = std::filesystem;
using nlohmann::json;

/// Some solvers of an experiment, as they are fitted for the clock.
struct Clocks::Part {
  Experiment experiment;
  std::set<std::string> labels;
  fs::path folder;  ///< of its records
};

/// A published result with the rows that are to be timed.
struct Clocks::Published {
  Experiment experiment;
  fs::path folder;
  json summary;
  std::vector<ResultRow> rows;
  std::vector<Part> parts;
  std::set<std::string> briefly_trained;  ///< labels

  Published(const fs::path& file, const fs::path& project);

  /// Puts what the clock said into rows and summary.
  void collect(const Cache& cache);
  /// Puts them into the place of what is published. `names`: of all that were timed together.
  void write(const std::vector<std::string>& names, const std::string& date) const;
};

namespace {

/// Whether solvers of the type are trained from random numbers, epoch by epoch.
bool is_trained(const std::string& type, SolverRegistry& registry) {
  const SolverInfo* info = registry.find(type);
  return info && info->comparison == ImageComparison::seeds && info->parameter("epochs");
}

/// The overrides that train the networks of `labels` as briefly as the clock needs.
std::vector<std::string> brief_trainings(const Experiment& experiment,
                                         const std::set<std::string>& labels) {
  std::vector<std::string> out;
  if (experiment.training && !experiment.training->measured()) {
    out.push_back("datasets.train.count=" + std::to_string(clock_scenes));
  }
  std::set<std::string> paths;
  for (const SolverEntry& entry : experiment.solvers) {
    if (labels.count(entry.label) > 0) paths.insert(entry.path);
  }
  for (const std::string& path : paths) out.push_back(path + "/epochs=1");
  return out;
}

}  // namespace

Clocks::Published::Published(const fs::path& file, const fs::path& project) {
  SolverRegistry registry;
  experiment = read_experiment(file, registry, chart_types());
  folder = project / "results/published" / experiment.name;
  PublishedResult published = read_published(experiment, folder);
  summary = *published.summary;
  rows = std::move(published.rows);
  std::set<std::string> as_published;
  for (const ResultRow& row : rows) {
    if (!row.latency_us) continue;
    (is_trained(row.type, registry) ? briefly_trained : as_published).insert(row.label);
  }
  const fs::path records = project / "results/clocks";
  if (!as_published.empty()) {
    parts.push_back({experiment, as_published, records / experiment.name});
  }
  if (!briefly_trained.empty()) {
    parts.push_back({read_experiment(file, registry, {}, SolverCheck::all,
                                     brief_trainings(experiment, briefly_trained)),
                     briefly_trained, records / (experiment.name + "-trained")});
  }
}

void Clocks::Published::collect(const Cache& cache) {
  ExperimentResults results;
  results.rows = std::move(rows);
  for (const Part& part : parts) {
    const ClockStage stage(part.labels, std::nullopt, true);
    const JobRecords records(stage, part.experiment, part.folder, cache.reuse());
    for (const Job& job : stage.due(part.experiment, results)) {
      if (records.read(job)) continue;
      throw InputError(records.file(job).string() +
                       ": there is no record of this round; all published times are as they were");
    }
    // What a training for the clock holds in memory says nothing of the published one.
    std::vector<std::optional<double>> memory;
    for (ResultRow& row : results.rows) {
      memory.push_back(row.peak_rss_mb);
      if (part.labels.count(row.label) > 0) row.build.timed.clear();
    }
    stage.collect(part.experiment, cache, records, results);
    add_builds(stage, part.experiment, records, results);
    for (std::size_t i = 0; i < memory.size(); ++i) results.rows[i].peak_rss_mb = memory[i];
  }
  rows = std::move(results.rows);
  summary["builds"]["timing"] = to_json(results.builds).at("timing");
}

void Clocks::Published::write(const std::vector<std::string>& names,
                              const std::string& date) const {
  std::vector<std::string> others = names;
  std::erase(others, experiment.name);
  const BuildStamp build = stamp_of_this_build({}, experiment.plugins);
  json changed = summary;
  changed["clocks"] = {
      {"date", date},
      {"cpu", cpu_name()},
      {"system", machine_provenance().at("system")},
      {"build", "commit " + build.commit_text() + ", program " + build.program.substr(0, 8)},
      {"together_with", others},
      {"briefly_trained", briefly_trained}};
  rewrite_published(experiment, folder, rows, changed);
}

Clocks::Clocks(const std::vector<fs::path>& experiments, fs::path project, const Cache& cache)
    : cache_(cache) {
  std::set<std::string> names;
  for (const fs::path& file : experiments) {
    results_.emplace_back(file, project);
    if (names.insert(results_.back().experiment.name).second) continue;
    throw InputError(file.string() + ": named twice");
  }
}

Clocks::~Clocks() = default;

void Clocks::take(int jobs) const {
  /// Runs a round, or all, of a part's jobs.
  const auto run = [&](const Part& part, int round, bool alone) {
    Stages stages;
    stages.push_back(std::make_unique<ClockStage>(part.labels, round, alone));
    RunOptions options;
    options.out = part.folder;
    options.jobs = jobs;
    if (run_stages(stages, part.experiment, cache_, options).failures == 0) return;
    throw InputError(part.folder.string() +
                     ": a solver could not be fitted or timed, as said above; all published times "
                     "are as they were");
  };
  const auto for_all_parts = [&](const auto& work) {
    for (const Published& result : results_) {
      std::for_each(result.parts.begin(), result.parts.end(), work);
    }
  };
  int rounds = 0;
  for_all_parts([&](const Part& part) {
    fs::remove_all(part.folder);
    rounds = std::max(rounds, part.experiment.timing.rounds);
    run(part, 0, false);  // what is not in the cache is fitted here
    fs::remove_all(part.folder);
  });
  for (int round = 0; round < rounds; ++round) {
    spdlog::info("clocks: round {} of {}", round + 1, rounds);
    for_all_parts([&](const Part& part) {
      if (round < part.experiment.timing.rounds) run(part, round, true);
    });
  }
}

void Clocks::write() const {
  std::vector<Published> timed = results_;
  std::vector<std::string> names;
  for (Published& result : timed) {
    result.collect(cache_);
    names.push_back(result.experiment.name);
  }
  const std::string date = utc_now();
  for (const Published& result : timed) result.write(names, date);
}

}  // namespace ertbench
