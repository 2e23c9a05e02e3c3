#pragma once

#include <memory>
#include <vector>

#include "bench/experiment/chart_type.h"

namespace ertbench {

/// Reads "charts" of an experiment file, objects with a "type", a "name", a "dataset" (by default
/// the first test set) and the keys of their type. Solvers, datasets and timing must be read
/// already. Throws InputError.
std::vector<std::shared_ptr<const Chart>> read_charts(JsonObject& root,
                                                      const Experiment& experiment,
                                                      const ChartTypes& types,
                                                      SolverRegistry& registry);

}  // namespace ertbench
