#pragma once

#include "bench/record/result_row.h"

namespace ertbench {

/// How many of a row's training runs came to rest within their budget of epochs.
struct Convergence {
  int runs = 0;           ///< one for each seed; 0 where nothing was trained
  int not_converged = 0;  ///< of these, the runs whose best epoch is the last that was allowed

  bool all() const { return not_converged == 0; }
};

/// Reads it from what the trainings reported in the row's parameters, `"training": {"best_epoch",
/// "converged"}`; where an earlier program did not say `"converged"`, from `"epochs"` beside it.
Convergence convergence_of(const ResultRow& row);

}  // namespace ertbench
