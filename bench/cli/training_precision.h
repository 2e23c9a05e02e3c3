#pragma once

#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// The overrides (`--set`) that have the experiment's networks trained in `precision` ("float32")
/// where its file has them trained in bfloat16: "/solvers/13/precision=float32".
std::vector<std::string> precision_overrides(const Experiment& experiment,
                                             const std::string& precision);

/// Warns of trainings that may take many times as long here as elsewhere: in bfloat16, on a
/// processor without it, and not in the cache. `only`: labels or families that are run; empty: all.
void warn_of_slow_trainings(const Experiment& experiment, const Cache& cache,
                            const std::vector<std::string>& only = {});

}  // namespace ertbench
