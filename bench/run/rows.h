#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/record/accuracy_record.h"
#include "bench/record/timing_record.h"
#include "bench/run/job_records.h"

namespace ertbench {

/// What fitting and scoring one entry gave.
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

}  // namespace ertbench
