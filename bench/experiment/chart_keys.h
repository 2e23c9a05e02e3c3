#pragma once

#include <string>
#include <vector>

#include "bench/score/metric_table.h"

/// Keys that charts of several types have. All throw InputError.
namespace ertbench {

class JsonObject;
struct Experiment;

/// "solvers": labels of rows, the label of a sweep or the name of a family standing for all of its
/// rows. Without the key, all rows.
std::vector<std::string> read_row_labels(JsonObject& object, const Experiment& experiment);

/// "solver": the label of a sweep of two parameters; the labels of its rows.
std::vector<std::string> read_sweep_labels(JsonObject& object, const Experiment& experiment);

/// "metrics": names out of the table of metrics, none twice.
std::vector<Metric> read_metrics(JsonObject& object, std::vector<Metric> fallback);

}  // namespace ertbench
