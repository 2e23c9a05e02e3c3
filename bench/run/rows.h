#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/records.h"

namespace ertbench {

/// Why there is no record of a stage.
struct Failure {
  std::string status;  ///< "failed", "timed out", "crashed", "not run"
  std::string message;
};

/// What a trial left.
struct TrialOutcome {
  const SolverEntry* entry = nullptr;
  std::optional<AccuracyRecord> accuracy;
  Failure failure;  ///< where there is no accuracy record
  std::optional<TimingRecord> timing;
  std::optional<Failure> timing_failure;
};

/// The rows of one label, one for each test set, out of its trials: one, or one for each seed.
/// Whatever went wrong stands in status and message; the numbers are those of the seeds that have
/// any.
std::vector<ResultRow> rows_of(const Experiment& experiment, std::span<const TrialOutcome> trials);

}  // namespace ertbench
