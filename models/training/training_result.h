#pragma once

#include <nlohmann/json_fwd.hpp>

#include "solvers/solver.h"

namespace ertbench {

/// How a training went.
struct TrainingResult {
  FitReport report;
  int epochs = 0;      ///< finished
  int best_epoch = 0;  ///< whose weights were kept, from 1
  /// False where the best epoch is the last one that was allowed: the validation error was still
  /// falling when the budget ended, and a longer training may give a better network. A learning
  /// rate that falls to 0 by then makes that the usual end, and does not say how much is to gain.
  bool converged = true;
  double validation_error = 0;  ///< of those weights
  double seconds = 0;           ///< all its parts together, where it was interrupted
};

/// `{"status", "message", "earlier_s", "epochs", "best_epoch", "validation_error", "seconds"}`, and
/// `"converged": false` where it had not.
nlohmann::json to_json(const TrainingResult& result);
TrainingResult training_result_from_json(const nlohmann::json& json);

}  // namespace ertbench
