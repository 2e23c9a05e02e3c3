#include "bench/runner.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <deque>
#include <fstream>
#include <list>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "bench/process.h"
#include "bench/progress.h"
#include "bench/results.h"
#include "bench/trial.h"
#include "forward/dataset_file.h"
#include "forward/errors.h"
#include "forward/generate.h"
#include "forward/json_reader.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

int cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

/// How a stage that left no record ended.
struct Failure {
  std::string status;
  std::string message;
};

std::string last_line(const fs::path& log) {
  std::ifstream in(log);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

Failure failure_of(const ProcessEnd& end, const fs::path& log, double time_limit_s) {
  if (end.timed_out) return {"timed out", "after " + duration_text(time_limit_s)};
  if (end.signal != 0) {
    return {"crashed", std::string(strsignal(end.signal)) + "; see " + log.string()};
  }
  const std::string line = last_line(log);
  return {"failed", line.empty() ? "exit code " + std::to_string(end.exit_code) : line};
}

/// Runs stages in processes of their own, some at a time, and remembers what failed.
class StageRunner {
 public:
  StageRunner(const Experiment& experiment, const RunOptions& options)
      : experiment_(experiment), options_(options), program_(fs::read_symlink("/proc/self/exe")) {}

  void run(Stage stage, const std::vector<const SolverEntry*>& entries, int jobs) {
    std::deque<const SolverEntry*> waiting;
    for (const SolverEntry* entry : entries) {
      if (read_record(experiment_, *entry, stage, options_.out)) continue;
      waiting.push_back(entry);
    }
    const std::size_t total = waiting.size();
    if (total == 0) return;
    Progress progress(std::string(name_of(stage)) + " of " + std::to_string(total) + " solver(s)");
    std::list<Running> running;
    std::size_t done = 0;
    progress.update(0, total);
    while (!waiting.empty() || !running.empty()) {
      while (!waiting.empty() && running.size() < static_cast<std::size_t>(jobs)) {
        running.push_back(start(stage, *waiting.front(), std::max(1, cores() / jobs)));
        waiting.pop_front();
      }
      for (auto trial = running.begin(); trial != running.end();) {
        const auto end = trial->process.poll();
        if (!end) {
          ++trial;
          continue;
        }
        finish(stage, *trial, *end);
        trial = running.erase(trial);
        progress.update(++done, total);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  const std::map<std::string, Failure>& failures() const { return failures_; }

 private:
  struct Running {
    const SolverEntry* entry;
    fs::path log;
    ChildProcess process;
  };

  Running start(Stage stage, const SolverEntry& entry, int threads) {
    fs::path log = record_file(options_.out, entry, stage);
    log.replace_extension(".log");
    const std::vector<std::string> arguments = {program_.string(),
                                                "trial",
                                                experiment_.file.string(),
                                                "--label=" + entry.label,
                                                "--stage=" + std::string(name_of(stage)),
                                                "--out=" + options_.out.string(),
                                                "--threads=" + std::to_string(threads)};
    return {&entry, log, ChildProcess(arguments, log, experiment_.time_limit_s)};
  }

  void finish(Stage stage, const Running& trial, const ProcessEnd& end) {
    const std::string& label = trial.entry->label;
    if (end.ok() && read_record(experiment_, *trial.entry, stage, options_.out)) return;
    const Failure failure = failure_of(end, trial.log, experiment_.time_limit_s);
    spdlog::warn("{} ({}): {}: {}", label, name_of(stage), failure.status, failure.message);
    failures_.emplace(label, failure);
  }

  const Experiment& experiment_;
  const RunOptions& options_;
  fs::path program_;
  std::map<std::string, Failure> failures_;
};

void forget(const Experiment& experiment, const Cache& cache, const RunOptions& options,
            const std::vector<const SolverEntry*>& entries) {
  for (const SolverEntry* entry : entries) {
    for (const Stage stage : {Stage::accuracy, Stage::timing}) {
      fs::remove(record_file(options.out, *entry, stage));
    }
    const fs::path fitted = cache.fitted_solver(experiment, *entry);
    fs::path note = fitted;
    note += ".json";
    fs::remove(note);
    fs::remove(fitted);
    fs::path work = fitted;
    fs::remove_all(work.replace_extension(".work"));
  }
}

/// The rows of one solver, from its records or from its failure.
std::vector<ResultRow> rows_of(const Experiment& experiment, const SolverEntry& entry,
                               const RunOptions& options, const StageRunner& stages,
                               ExperimentResults& results) {
  const auto accuracy = read_record(experiment, entry, Stage::accuracy, options.out);
  const auto failure = stages.failures().find(entry.label);
  std::vector<ResultRow> rows;
  if (!accuracy) {
    for (const DatasetSpec& test : experiment.tests) {
      ResultRow row;
      row.label = entry.label;
      row.type = entry.type;
      row.dataset = test.name;
      row.parameters_json = entry.json;
      const bool failed = failure != stages.failures().end();
      row.status = failed ? failure->second.status : "not run";
      row.message = failed ? failure->second.message : "left out by --only";
      rows.push_back(row);
    }
    return rows;
  }
  const std::string source = record_file(options.out, entry, Stage::accuracy).string();
  for (std::size_t i = 0; i < accuracy->at("rows").size(); ++i) {
    rows.push_back(result_row_from_json(
        JsonObject(accuracy->at("rows")[i], source, "/rows/" + std::to_string(i))));
  }
  const json& images = accuracy->at("figure_images");
  Images& kept = results.images[entry.label];
  kept.resize(static_cast<Eigen::Index>(images.size()), experiment.sensor.pixels());
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (std::size_t p = 0; p < images[i].size(); ++p) {
      kept(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p)) =
          images[i][p].is_null() ? std::nan("") : images[i][p].get<double>();
    }
  }
  if (!experiment.timing.enabled) return rows;
  const auto timing = read_record(experiment, entry, Stage::timing, options.out);
  for (ResultRow& row : rows) {
    if (timing) {
      const json& measured = timing->at("timing").at(row.dataset);
      row.latency_us = summarise_latency(measured.at("latency_us").get<std::vector<double>>());
      row.frames_per_s = measured.at("frames_per_s").get<double>();
      row.throughput_batch = measured.at("batch").get<int>();
      row.peak_rss_mb = timing->at("peak_rss_mb").get<double>();
    } else if (failure != stages.failures().end()) {
      row.status = failure->second.status;
      row.message = "timing: " + failure->second.message;
    }
  }
  return rows;
}

}  // namespace

void ensure_datasets(const Experiment& experiment, const Cache& cache) {
  fs::create_directories(cache.folder() / "datasets");
  for (const DatasetSpec* spec : experiment.datasets()) {
    const fs::path file = cache.dataset(*spec);
    if (fs::exists(file)) continue;
    Progress progress("generating \"" + spec->name + "\" (" + std::to_string(spec->count) +
                      " scenes, grid " + std::to_string(spec->grid) + ")");
    generate_dataset(*spec, file, {cores(), [&](std::uint64_t done, std::uint64_t total) {
                                     progress.update(done, total);
                                   }});
  }
}

int run_experiment(const Experiment& experiment, const Cache& cache, const RunOptions& options) {
  std::vector<const SolverEntry*> entries;
  for (const SolverEntry& entry : experiment.solvers) {
    const bool wanted = options.only.empty() || std::find(options.only.begin(), options.only.end(),
                                                          entry.label) != options.only.end();
    if (wanted) entries.push_back(&entry);
  }
  fs::create_directories(options.out / "records");
  if (options.fresh) forget(experiment, cache, options, entries);
  ensure_datasets(experiment, cache);

  StageRunner stages(experiment, options);
  stages.run(Stage::accuracy, entries, options.jobs);
  if (experiment.timing.enabled) {
    std::vector<const SolverEntry*> fitted;
    for (const SolverEntry* entry : entries) {
      if (!stages.failures().count(entry->label)) fitted.push_back(entry);
    }
    stages.run(Stage::timing, fitted, 1);
  }

  ExperimentResults results;
  results.jobs = options.jobs;
  results.rows = reference_rows(experiment, cache);
  for (const SolverEntry& entry : experiment.solvers) {
    const std::vector<ResultRow> rows = rows_of(experiment, entry, options, stages, results);
    results.rows.insert(results.rows.end(), rows.begin(), rows.end());
  }
  // Test set by test set, each beginning with its truth.
  std::stable_sort(results.rows.begin(), results.rows.end(),
                   [&](const ResultRow& a, const ResultRow& b) {
                     const auto place = [&](const ResultRow& row) {
                       return experiment.find_dataset(row.dataset);
                     };
                     return place(a) < place(b);
                   });
  write_results(experiment, cache, results, options.out);
  std::printf("%s\n%s\n", console_table(results.rows).c_str(),
              ("Results in " + options.out.string()).c_str());
  return static_cast<int>(stages.failures().size());
}

}  // namespace ertbench
