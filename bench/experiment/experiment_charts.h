#pragma once

#include <vector>

#include "bench/experiment/chart_spec.h"

namespace ertbench {

class JsonObject;
struct Experiment;

/// Reads "charts" of an experiment file: `{"type": "bars", "name", "solvers": [labels], "metrics",
/// "dataset"}` and `{"type": "heat-map", "name", "solver": the label of a sweep of two parameters,
/// "metrics", "dataset", "published_optimum": [first, second]}` and `{"type": "speed-accuracy",
/// "name", "solvers", "metric", "dataset", "budgets_us", "break_even_against": [labels]}`. Solvers
/// and datasets must be read already. Throws InputError.
std::vector<ChartSpec> read_charts(JsonObject& root, const Experiment& experiment);

}  // namespace ertbench
