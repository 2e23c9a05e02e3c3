#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/record/cache.h"
#include "bench/record/measurement_records.h"
#include "bench/record/result_row.h"
#include "bench/run/job_runner.h"
#include "bench/score/image_contacts.h"

namespace ertbench {

/// The mean and the sample standard deviation of the values that are there; nothing for none, and
/// for fewer than two.
std::optional<double> mean_of(const std::vector<std::optional<double>>& values);
std::optional<double> deviation_of(const std::vector<std::optional<double>>& values);

/// The results of one training seed on one test set.
struct SeedResult {
  int seed;
  const ScoredSet* set;
};

/// One row out of those of several seeds (at least one, all of the same frames). Each metric's mean
/// is the mean of the seeds' means. Interval and median are those of the frames, the value of a
/// frame being its mean over the seeds; a frame that is undefined for any seed counts as undefined
/// there, and in the row's `undefined_frames`. `fit_s` is the median. `parameters` is the first
/// seed's; status and message are left to the caller.
ResultRow combine_seeds(std::span<const SeedResult> results);

/// Outcome of fitting and scoring one entry.
struct ScoredTrial {
  const SolverEntry* entry = nullptr;
  std::optional<AccuracyRecord> accuracy;
  Failure failure;  ///< why there is no record, where there is none
};

/// The rows of one label, one for each test set, out of its trials: one, or one for each seed.
/// Whatever went wrong stands in status and message; the numbers are those of the seeds that have
/// any.
std::vector<ResultRow> rows_of(std::span<const DatasetSpec> tests,
                               std::span<const ScoredTrial> trials);

/// What the clock gave for one entry.
struct TimedTrial {
  const SolverEntry* entry = nullptr;
  std::optional<TimingRecord> timing;
  std::optional<Failure> failure;
};

/// Puts the times of the one trial of the row's label that was timed into the row, or what went
/// wrong with it.
void add_times(std::span<const TimedTrial> trials, ResultRow& row);

/// The rows that need no solver: the true images themselves, scored like any other, and the image
/// of an untouched sheet. Contacts are read out of both by the rule that holds where none is chosen
/// (ContactSettings::rule).
std::vector<ResultRow> reference_rows(const Sensor& sensor, std::span<const DatasetSpec> tests,
                                      const ContactSettings& contacts, const Cache& cache);

}  // namespace ertbench
