#include "bench/cluster/slurm.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "bench/features/features.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The standard output of a Slurm command. Throws InputError if it fails.
std::string output_of(const std::vector<std::string>& command) {
  constexpr double most_s = 120;  // a busy controller answers late
  const TemporaryFolder folder;
  ChildProcess process(command, {folder.path() / "log", folder.path() / "output"}, {most_s});
  const ProcessEnd end = process.wait();
  if (end.ok()) return contents_of(folder.path() / "output");
  if (end.exit_code == ChildProcess::not_started) {
    throw InputError(command[0] +
                     " is not here: --engine slurm is for a machine from which jobs are submitted "
                     "(Debian: slurm-client)");
  }
  const std::string said = one_line(contents_of(folder.path() / "log"), 300);
  throw InputError(command[0] + ": " + (said.empty() ? end.text() : printable(said, 300)));
}

long required_number(std::string_view text, const std::string& line) {
  const auto value = whole_number<long>(text);
  if (!value) throw InputError("squeue: cannot read \"" + printable(line) + "\"");
  return *value;
}

/// "3", "7-9", "0-8:4" of the array's elements.
void add_range(const std::string& range, const std::string& line, std::vector<int>& elements) {
  const std::string_view text = range;
  const std::size_t colon = text.find(':');
  const long step =
      colon == std::string_view::npos ? 1 : required_number(text.substr(colon + 1), line);
  const std::string_view ends = text.substr(0, colon);
  const std::size_t dash = ends.find('-');
  const long first = required_number(ends.substr(0, dash), line);
  const long last =
      dash == std::string_view::npos ? first : required_number(ends.substr(dash + 1), line);
  for (long i = first; i <= last; i += std::max(1L, step)) elements.push_back(static_cast<int>(i));
}

/// "[3,7-9%2]" without its brackets: the elements of an array.
std::vector<int> elements_from(std::string text, const std::string& line) {
  std::erase_if(text, [](char c) { return c == '[' || c == ']'; });
  text = text.substr(0, text.find('%'));
  std::vector<int> elements;
  for (const std::string& range : split(text, ",")) {
    if (!range.empty()) add_range(range, line, elements);
  }
  return elements;
}

/// Groups units into elements so that there are not too many elements.
std::vector<Units> elements_of(const Units& units, std::size_t most) {
  const std::size_t each = std::max<std::size_t>(1, (units.size() + most - 1) / most);
  std::vector<Units> elements;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (i % each == 0) elements.emplace_back();
    elements.back().push_back(units[i]);
  }
  return elements;
}

/// See slurm_plan.
struct Planner {
  const Experiment& experiment;
  const Cache& cache;
  const LiveUnits& live;
  const SlurmOptions& options;
  std::size_t most;  ///< elements of an array

  std::vector<SlurmPart> plan() {
    std::vector<SlurmPart> parts;
    for (const auto& stage : stages_of_run(experiment, Machines::any)) {
      const Units units = missing_units(*stage);
      if (units.empty()) continue;
      const bool alone = stage->wants_machine_alone();
      parts.push_back({stage->name(),
                       alone ? elements_of_labels(*stage, units) : elements_of(units, most),
                       alone});
    }
    if (!parts.empty()) {
      // One element each, since the training set may take a thousand times as long as the others.
      // Elements also check existing datasets.
      SlurmPart datasets{"datasets", {}, false};
      for (const DatasetSpec* spec : experiment.datasets()) {
        if (!live.contains({"datasets", spec->name})) datasets.elements.push_back({spec->name});
      }
      if (!datasets.elements.empty()) parts.insert(parts.begin(), std::move(datasets));
    }
    parts.push_back({"report", {{}}, false});
    return parts;
  }

  /// Units of a stage: entries for accuracy; for other stages, which use the first scored entry of
  /// a label, the labels for which no entry has all records.
  Units missing_units(const Stage& stage) const {
    if (stage.name() == "timing" && !experiment.timing.enabled) return {};
    if (stage.name() == "ladders" && !experiment.ladders) return {};
    const bool by_entry = stage.name() == "accuracy";
    const JobRecords records(stage, experiment, options.out, cache.reuse());
    std::vector<std::pair<const SolverEntry*, std::vector<Job>>> jobs;
    for (const Job& job : stage.jobs(experiment)) {
      if (!job.entry || !job.entry->is_wanted(options.only)) continue;
      const auto found =
          std::ranges::find_if(jobs, [&](const auto& one) { return one.first == job.entry; });
      (found == jobs.end() ? jobs.emplace_back(job.entry, std::vector<Job>()) : *found)
          .second.push_back(job);
    }
    Units units;
    std::set<std::string> complete;
    for (const auto& [entry, of_entry] : jobs) {
      const std::string unit = by_entry ? entry->stem() : entry->label;
      if (std::ranges::all_of(of_entry, [&](const Job& job) { return records.has(job); })) {
        complete.insert(unit);
      }
    }
    for (const auto& [entry, of_entry] : jobs) {
      const std::string unit = by_entry ? entry->stem() : entry->label;
      if (complete.contains(unit) || live.contains({stage.name(), unit})) continue;
      if (units.empty() || units.back() != unit) units.push_back(unit);
    }
    return units;
  }

  /// Blocks of labels timed together, if one of them lacks a record.
  std::vector<Units> elements_of_labels(const Stage& stage, const Units& missing) const {
    Units labels;
    for (const auto& row : experiment.rows()) {
      if (row.front().is_wanted(options.only) &&
          !live.contains({stage.name(), row.front().label})) {
        labels.push_back(row.front().label);
      }
    }
    const std::size_t blocks =
        std::min(most, (labels.size() + most_timed_together - 1) / most_timed_together);
    std::vector<Units> elements = elements_of(labels, std::max<std::size_t>(1, blocks));
    std::erase_if(elements, [&](const Units& block) {
      return std::ranges::none_of(
          block, [&](const std::string& label) { return contains(missing, label); });
    });
    return elements;
  }
};

/// Ending of the file in which an element notes a failure.
constexpr const char* failed_ending = ".failed.json";

void note_failures(const JobRecords& records, const std::vector<Job>& jobs) {
  for (const Job& job : jobs) {
    const fs::path note = records.file(job, failed_ending);
    const Failure* failure = records.failure(job);
    if (!failure) {
      fs::remove(note);
      continue;
    }
    write_file_atomically(note, json_text(json{{"status", failure->status},
                                               {"message", failure->message},
                                               {"node", host_name()},
                                               {"date", utc_now()}},
                                          2));
  }
}

/// The failure that the job's element noted, or that it noted none.
Failure why_missing(const fs::path& note) {
  if (!fs::exists(note)) {
    return {"lost", "its element of the array ended without a record; give the same command again"};
  }
  try {
    const json content = read_json_file(note);
    return {content.at("status").get<std::string>(),
            content.at("message").get<std::string>() + " (on " +
                content.at("node").get<std::string>() + ")"};
  } catch (const std::exception& error) {
    return {"failed", error.what()};
  }
}

int make_datasets(const Experiment& experiment, const Cache& cache, const ElementOptions& options) {
  fs::create_directories(cache.folder() / "datasets");
  for (const std::string& name : options.units) {
    const DatasetSpec* spec = experiment.find_dataset(name);
    if (!spec) throw InputError("the experiment has no dataset \"" + printable(name) + "\"");
    ensure_dataset(*spec, cache, options.threads);
  }
  return 0;
}

int make_report(const Experiment& experiment, const Cache& cache, const ElementOptions& options) {
  const Stages stages = stages_of_run(experiment, Machines::any);
  const ExperimentResults results = collect_stages(
      stages, experiment, cache, options, [&](const Job& job) -> std::optional<Failure> {
        return why_missing(record_file(options.out, job.name, failed_ending));
      });
  const std::size_t undrawn = report_experiment(experiment, cache, results, options.out);
  write_file_atomically(options.out / "slurm" / "outcome.json",
                        json_text(json{{"failures", results.failures}, {"undrawn", undrawn}}));
  return results.failures + static_cast<int>(undrawn);
}

/// The experiment with only the solvers whose entry or label is one of the units.
Experiment restricted_to(const Experiment& experiment, const Units& units) {
  const std::set<std::string> names(units.begin(), units.end());
  Experiment out = experiment;
  std::erase_if(out.solvers, [&](const SolverEntry& entry) {
    return names.count(entry.label) == 0 && names.count(entry.stem()) == 0;
  });
  return out;
}

}  // namespace

std::vector<SlurmTask> tasks_from(const std::string& text) {
  std::vector<SlurmTask> tasks;
  for (const std::string& line : split(text, "\n")) {
    if (line.empty()) continue;
    const std::vector<std::string> words = split(line, "|");
    if (words.size() != 4) throw InputError("squeue: cannot read \"" + printable(line) + "\"");
    SlurmTask task{required_number(words[0], line), std::nullopt, words[2], words[3]};
    if (words[1] == "N/A") {
      tasks.push_back(task);
      continue;
    }
    for (const int element : elements_from(words[1], line)) {
      task.element = element;
      tasks.push_back(task);
    }
  }
  return tasks;
}

std::vector<SlurmTask> live_tasks(std::span<const long> jobs) {
  if (jobs.empty()) return {};
  // Otherwise squeue truncates long lists of elements, and the rest would be submitted again.
  ::setenv("SLURM_BITSTR_LEN", "0", 1);
  // Not --jobs: squeue refuses the whole list if the controller has forgotten one number.
  std::vector<SlurmTask> tasks =
      tasks_from(output_of({"squeue", "-h", "--me", "-o", "%F|%K|%T|%N"}));
  std::erase_if(tasks, [&](const SlurmTask& task) {
    return task.state == "COMPLETING" || !contains(jobs, task.job);
  });
  return tasks;
}

long submit(const std::vector<std::string>& command) {
  const std::string said = output_of(command);
  // "12", or "12;cluster".
  const auto job = whole_number<long>(std::string_view(said).substr(0, said.find_first_of(";\n")));
  if (!job) throw InputError("sbatch: says no job's number but \"" + printable(said) + "\"");
  return *job;
}

void cancel(std::span<const long> jobs) {
  if (jobs.empty()) return;
  std::vector<std::string> command = {"scancel", "--quiet"};
  for (const long job : jobs) command.push_back(std::to_string(job));
  output_of(command);
}

int most_elements() {
  try {
    for (const std::string& line : split(output_of({"scontrol", "show", "config"}), "\n")) {
      if (!line.starts_with("MaxArraySize")) continue;
      const std::size_t equals = line.find("= ");
      if (equals == std::string::npos) break;
      if (const auto size = whole_number<long>(std::string_view(line).substr(equals + 2))) {
        return std::max(1, static_cast<int>(*size));
      }
    }
  } catch (const InputError&) {
  }
  return 1001;
}

std::vector<SlurmPart> slurm_plan(const Experiment& experiment, const Cache& cache,
                                  const LiveUnits& live, const SlurmOptions& options,
                                  int most_elements) {
  return Planner{experiment, cache, live, options, static_cast<std::size_t>(most_elements)}.plan();
}

int run_element(const Experiment& experiment, const Cache& cache, const ElementOptions& options) {
  fs::create_directories(options.out / "records");
  if (options.part == "datasets") return make_datasets(experiment, cache, options);
  if (options.part == "report") return make_report(experiment, cache, options);
  const Experiment own = restricted_to(experiment, options.units);
  ExperimentResults results;
  for (const std::unique_ptr<Stage>& stage : stages_of_run(own, Machines::any)) {
    JobRecords records(*stage, own, options.out, cache.reuse());
    if (stage->name() == options.part) {
      const TimingSession session(*stage, own, options.out, records, stage->due(own, results),
                                  stage->due(own, results));
      JobRunner runner(*stage, own, cache, options.out, records);
      runner.take_only(options.threads);
      runner.run(session.jobs(), 1);
      if (records.failures() == 0) session.finish();
      note_failures(records, session.jobs());
      return records.failures();
    }
    stage->collect(own, cache, records, results);
  }
  throw InputError("--part: no stage is called \"" + printable(options.part) + "\"");
}

}  // namespace ertbench
