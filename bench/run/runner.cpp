#include "bench/run/runner.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <deque>
#include <fstream>
#include <list>
#include <map>
#include <thread>

#include "bench/record/ladder_record.h"
#include "bench/record/progress_file.h"
#include "bench/record/records.h"
#include "bench/run/datasets.h"
#include "bench/run/reference_rows.h"
#include "bench/run/rows.h"
#include "core/errors.h"
#include "core/process.h"
#include "core/progress.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

int cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

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
  StageRunner(const Experiment& experiment, const Cache& cache, const RunOptions& options)
      : experiment_(experiment),
        cache_(cache),
        options_(options),
        program_(fs::read_symlink("/proc/self/exe")) {}

  void run(Stage stage, const std::vector<const SolverEntry*>& entries, int jobs) {
    std::deque<Waiting> waiting;
    const int rounds = stage == Stage::timing ? experiment_.timing.rounds : 1;
    for (int round = 0; round < rounds; ++round) {
      for (const SolverEntry* entry : entries) {
        const StagePart part{stage, round};
        if (!has_record(experiment_, *entry, part, options_.out)) waiting.push_back({entry, part});
      }
    }
    const std::size_t total = waiting.size();
    if (total == 0) return;
    Progress progress(std::string(name_of(stage)) + " of " + std::to_string(total) +
                      (stage == Stage::timing ? " round" : " trial") + (total == 1 ? "" : "s"));
    std::list<Running> running;
    std::size_t done = 0;
    auto last_look = std::chrono::steady_clock::now();
    show(progress, done, total, running);
    while (!waiting.empty() || !running.empty()) {
      while (!waiting.empty() && running.size() < static_cast<std::size_t>(jobs)) {
        const Waiting next = waiting.front();
        waiting.pop_front();
        if (failure(*next.entry, stage)) {  // in an earlier round
          ++done;
          continue;
        }
        running.push_back(start(next, std::max(1, cores() / jobs)));
      }
      const std::size_t done_before = done;
      for (auto trial = running.begin(); trial != running.end();) {
        const auto end = trial->process.poll();
        if (!end) {
          ++trial;
          continue;
        }
        finish(*trial, *end);
        trial = running.erase(trial);
        ++done;
      }
      const auto now = std::chrono::steady_clock::now();
      if (done != done_before || now - last_look > std::chrono::milliseconds(500)) {
        show(progress, done, total, running);
        last_look = now;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  /// Null where the stage did not fail.
  const Failure* failure(const SolverEntry& entry, Stage stage) const {
    const auto found = failures_.find({entry.stem(), stage});
    return found == failures_.end() ? nullptr : &found->second;
  }
  std::size_t failure_count() const { return failures_.size(); }

 private:
  struct Waiting {
    const SolverEntry* entry;
    StagePart part;
  };
  struct Running {
    const SolverEntry* entry;
    StagePart part;
    fs::path log;
    fs::path progress;
    ChildProcess process;
  };

  Running start(const Waiting& next, int threads) {
    const SolverEntry& entry = *next.entry;
    fs::path log = record_file(options_.out, entry, next.part, ".log");
    fs::path progress = record_file(options_.out, entry, next.part, ".progress");
    remove_progress(progress);
    std::vector<std::string> arguments = {program_.string(),
                                          "trial",
                                          experiment_.file.string(),
                                          "--label=" + entry.label,
                                          "--stage=" + std::string(name_of(next.part.stage)),
                                          "--round=" + std::to_string(next.part.round),
                                          "--out=" + options_.out.string(),
                                          "--cache=" + cache_.folder().string(),
                                          "--threads=" + std::to_string(threads)};
    if (entry.seed) arguments.push_back("--seed=" + std::to_string(*entry.seed));
    ChildProcess process(arguments, {log}, experiment_.time_limit_s);
    return {&entry, next.part, std::move(log), std::move(progress), std::move(process)};
  }

  void finish(const Running& trial, const ProcessEnd& end) {
    const Stage stage = trial.part.stage;
    remove_progress(trial.progress);
    if (end.ok() && has_record(experiment_, *trial.entry, trial.part, options_.out)) return;
    const Failure failure = failure_of(end, trial.log, experiment_.time_limit_s);
    spdlog::warn("{} ({}): {}: {}", trial.entry->title(), name_of(stage), failure.status,
                 failure.message);
    failures_.emplace(std::pair(trial.entry->stem(), stage), failure);
  }

  /// A trial that runs counts by what it has done.
  static void show(Progress& progress, std::size_t done, std::size_t total,
                   const std::list<Running>& running) {
    constexpr double parts = 1000;
    double sum = static_cast<double>(done);
    std::string text;
    for (const Running& trial : running) {
      text += (text.empty() ? "" : "; ") + trial.entry->title();
      const auto state = read_progress(trial.progress);
      if (!state) continue;
      sum += std::clamp(state->fraction, 0.0, 1.0);
      if (!state->text.empty()) text += " " + state->text;
      if (state->seconds_left > 0) text += ", " + duration_text(state->seconds_left) + " left";
    }
    progress.update(static_cast<std::uint64_t>(parts * sum),
                    static_cast<std::uint64_t>(parts) * total, text);
  }

  const Experiment& experiment_;
  const Cache& cache_;
  const RunOptions& options_;
  fs::path program_;
  std::map<std::pair<std::string, Stage>, Failure> failures_;  ///< by the entry's stem
};

void forget(const Experiment& experiment, const Cache& cache, const RunOptions& options,
            const std::vector<const SolverEntry*>& entries) {
  for (const SolverEntry* entry : entries) {
    fs::remove(record_file(options.out, *entry, {Stage::accuracy}));
    fs::remove(record_file(options.out, *entry, {Stage::ladders}));
    for (int round = 0; round < experiment.timing.rounds; ++round) {
      fs::remove(record_file(options.out, *entry, {Stage::timing, round}));
    }
    const fs::path fitted = cache.fitted_solver(experiment, *entry);
    fs::path note = fitted;
    note += ".json";
    fs::remove(note);
    fs::remove(fitted);
    fs::remove_all(cache.work_folder(experiment, *entry));
  }
}

/// What the trial left in the result folder, and what failed just now.
TrialOutcome outcome_of(const Experiment& experiment, const SolverEntry& entry,
                        const RunOptions& options, const StageRunner& stages) {
  TrialOutcome outcome;
  outcome.entry = &entry;
  outcome.accuracy = read_accuracy_record(experiment, entry, options.out);
  const Failure* failure = stages.failure(entry, Stage::accuracy);
  outcome.failure = failure ? *failure : Failure{"not run", "left out by --only"};
  if (!experiment.timing.enabled) return outcome;
  outcome.timing = read_timing_record(experiment, entry, options.out);
  if (const Failure* timing = stages.failure(entry, Stage::timing)) {
    outcome.timing_failure = *timing;
  }
  return outcome;
}

std::string text_of(const Failure& failure) { return failure.status + ": " + failure.message; }

/// Of the first of a label's trials that was scored.
LadderOutcome ladders_of(const Experiment& experiment, std::span<const TrialOutcome> trials,
                         const RunOptions& options, const StageRunner& stages) {
  const auto scored = std::find_if(trials.begin(), trials.end(),
                                   [](const TrialOutcome& trial) { return !!trial.accuracy; });
  if (scored == trials.end()) {
    return {trials.front().entry, std::nullopt, text_of(trials.front().failure)};
  }
  LadderOutcome outcome{scored->entry, read_ladder_record(experiment, *scored->entry, options.out),
                        ""};
  if (outcome.record) return outcome;
  const Failure* failure = stages.failure(*scored->entry, Stage::ladders);
  outcome.failure = failure ? text_of(*failure) : "not run: left out by --only";
  return outcome;
}

/// The first seed of each label that was scored, which is timed and takes the ladders: the others
/// take as long, and show their spread in the table.
std::vector<const SolverEntry*> first_seeds(const Experiment& experiment,
                                            const std::vector<const SolverEntry*>& entries,
                                            const RunOptions& options) {
  std::vector<const SolverEntry*> out;
  for (const SolverEntry* entry : entries) {
    if (!out.empty() && out.back()->label == entry->label) continue;
    if (has_record(experiment, *entry, {Stage::accuracy}, options.out)) out.push_back(entry);
  }
  return out;
}

bool is_wanted(const SolverEntry& entry, const RunOptions& options) {
  return options.only.empty() ||
         std::any_of(options.only.begin(), options.only.end(), [&](const std::string& label) {
           return label == entry.label || label == entry.family;
         });
}

}  // namespace

ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options) {
  std::vector<const SolverEntry*> entries;
  for (const SolverEntry& entry : experiment.solvers) {
    if (is_wanted(entry, options)) entries.push_back(&entry);
  }
  fs::create_directories(options.out / "records");
  if (options.fresh) forget(experiment, cache, options, entries);
  ensure_datasets(experiment, cache);

  StageRunner stages(experiment, cache, options);
  stages.run(Stage::accuracy, entries, options.jobs);
  if (experiment.timing.enabled) {
    stages.run(Stage::timing, first_seeds(experiment, entries, options), 1);
  }
  if (experiment.ladders) {
    stages.run(Stage::ladders, first_seeds(experiment, entries, options), options.jobs);
  }

  ExperimentResults results;
  results.jobs = options.jobs;
  results.rows = reference_rows(experiment, cache);
  for (const std::span<const SolverEntry> trials : experiment.rows()) {
    std::vector<TrialOutcome> outcomes;
    for (const SolverEntry& entry : trials) {
      outcomes.push_back(outcome_of(experiment, entry, options, stages));
      const auto& accuracy = outcomes.back().accuracy;
      if (!accuracy) continue;
      results.images.emplace(entry.label, accuracy->figure_images);  // the first seed's
      results.training[entry.label].push_back(
          {entry.stem(), entry.seed ? "seed " + std::to_string(*entry.seed) : "",
           cache.work_folder(experiment, entry) / "training.csv",
           accuracy->sets.front().row.parameters_json});
    }
    if (experiment.ladders)
      results.ladders.push_back(ladders_of(experiment, outcomes, options, stages));
    const std::vector<ResultRow> rows = rows_of(experiment, outcomes);
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
  results.failures = static_cast<int>(stages.failure_count());
  return results;
}

}  // namespace ertbench
