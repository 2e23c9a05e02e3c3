#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/score/metrics.h"

namespace ertbench {

class Chart;  // bench/charts/chart.h; an experiment keeps its charts and knows nothing of drawing
class JsonObject;
class SolverRegistry;
struct Experiment;

/// What every chart has: the name of its files, and the test set whose rows it shows.
struct ChartPlace {
  std::string name;
  std::string dataset;
};

/// What a chart is read from.
struct ChartRequest {
  JsonObject& object;            ///< its own keys; "type", "name" and "dataset" are taken already
  ChartPlace place;              ///< those
  const Experiment& experiment;  ///< with its datasets, solvers and timing read
  SolverRegistry& registry;
};

/// One value of a chart's "type".
struct ChartType {
  std::string name;
  /// Reads the chart. Throws InputError naming file, JSON path and remedy.
  std::function<std::shared_ptr<const Chart>(const ChartRequest&)> read;
};

/// All that "type" may be, in the order in which messages name them.
using ChartTypes = std::vector<ChartType>;

}  // namespace ertbench

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

/// Reads "charts" of an experiment file, objects with a "type", a "name", a "dataset" (by default
/// the first test set) and the keys of their type. Solvers, datasets and timing must be read
/// already. Throws InputError.
std::vector<std::shared_ptr<const Chart>> read_charts(JsonObject& root,
                                                      const Experiment& experiment,
                                                      const ChartTypes& types,
                                                      SolverRegistry& registry);

}  // namespace ertbench
