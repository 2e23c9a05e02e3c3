#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/experiment/solver_entry.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
#include "bench/report/report.h"

namespace ertbench {

/// A unit of work of a stage, done in one process. `name` is its identity: `ertbench trial` is told
/// it, and its record, its log and its progress are files of that name.
struct Job {
  std::string name;     ///< unique among all stages: "tsvd.timing.2", "train.fidelity"
  std::string subject;  ///< what it is about, in all rounds the same: "tsvd", "train"
  std::string title;    ///< that for people: "dd-ert seed 2"
  const SolverEntry* entry = nullptr;  ///< whose solver it runs; null where it runs none
  int round = 0;                       ///< of a stage that comes back to a subject, from 0
};

class JobRecords;
class SolverRegistry;

/// Environment of a job in its own process.
struct JobContext {
  const Experiment& experiment;
  const Cache& cache;
  SolverRegistry& registry;
  int threads = 1;
  std::filesystem::path progress_file;  ///< where it may say how far it is, see ProgressFile
};

/// One kind of work on an experiment: fitting and scoring, reading the clock, climbing ladders,
/// comparing the models of the sheet. A stage says which jobs there are and what one job does; the
/// runner gives each job a process of its own, keeps its record, and does again only what has no
/// record of the right key. A new kind of experiment is a class of this sort, in the list of
/// bench/features.
class Stage {
 public:
  virtual ~Stage() = default;

  /// Name in files, messages and `ertbench trial --stage`: "accuracy". Letters alone.
  virtual std::string name() const = 0;
  /// Noun for one job where jobs are counted: "trial", "round".
  virtual std::string noun() const { return "trial"; }
  /// Whether its jobs read the clock, so that nothing may run beside one.
  virtual bool wants_machine_alone() const { return false; }
  /// Whether its jobs find the experiment's datasets in the cache.
  virtual bool reads_datasets() const { return true; }
  /// Time limit of one job, s.
  virtual double time_limit_s(const Experiment& experiment) const {
    return experiment.time_limit_s;
  }
  /// Command line of `ertbench trial` beyond what all stages have: "--scenes=200".
  virtual std::vector<std::string> options() const { return {}; }

  /// Every job it may ever have on this experiment: one for each solver, or what a stage has.
  virtual std::vector<Job> jobs(const Experiment& experiment) const;
  /// Those that are wanted now, in the order in which they are to be run. `results`: what the
  /// stages before it found.
  virtual std::vector<Job> due(const Experiment& experiment,
                               const ExperimentResults& /*results*/) const {
    return jobs(experiment);
  }
  /// A hash of all that determines the job's record. Two builds of the program give the same.
  virtual std::string key(const Experiment& experiment, const Job& job) const = 0;
  /// Does the job, in its own process, and returns the record, to which the key is added.
  virtual nlohmann::json run(const Job& job, const JobContext& context) const = 0;
  /// Throws an exception of any kind where `record` is not one that this stage can read.
  virtual void check(const Experiment& experiment, const nlohmann::json& record) const = 0;

  /// Why a record that `check` takes is not to be reused on this machine; empty where it is.
  virtual std::string why_not_here(const nlohmann::json& /*record*/) const { return ""; }
  /// Whether the records of all its jobs are to be made in one go: where one is missing, all are
  /// made again, unless they were begun in the same go (TimingSession).
  virtual bool in_one_session() const { return false; }

  /// Adds what the jobs' records say to the results, and what became of jobs that left none.
  virtual void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
                       ExperimentResults& results) const = 0;
  /// Writes the files that are this stage's own into the result folder, and returns its sections of
  /// the experiment's page.
  virtual std::vector<ReportSection> report(const Experiment&, const ExperimentResults&,
                                            const std::filesystem::path& /*folder*/) const {
    return {};
  }
  /// Removes what the job left in the cache, so that it is made anew.
  virtual void forget(const Experiment&, const Cache&, const Job&) const {}
};

using Stages = std::vector<std::unique_ptr<Stage>>;

/// The job of an entry: "tsvd.accuracy".
Job job_of(const Stage& stage, const SolverEntry& entry);
/// One round of several: "tsvd.timing.2".
Job job_of(const Stage& stage, const SolverEntry& entry, int round);
/// A dataset's job: "train.fidelity".
Job job_of(const Stage& stage, const DatasetSpec& dataset);

}  // namespace ertbench
