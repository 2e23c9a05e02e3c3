#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/score/metrics.h"

namespace ertbench {

class Chart;  // drawn by bench/report; an experiment only keeps its charts
class SolverRegistry;
struct Experiment;

/// The name of a chart's files and the test set whose rows it shows.
struct ChartPlace {
  std::string name;
  std::string dataset;
};

/// The input from which a chart is read.
struct ChartRequest {
  JsonObject& object;            ///< its own keys; "type", "name" and "dataset" have been read
  ChartPlace place;              ///< "name" and "dataset"
  const Experiment& experiment;  ///< with its datasets, solvers and timing read
  SolverRegistry& registry;
};

/// One value of a chart's "type".
struct ChartType {
  std::string name;
  /// Reads the chart. Throws InputError naming file, JSON path and remedy.
  std::function<std::shared_ptr<const Chart>(const ChartRequest&)> read;
};

/// The known types, in the order in which messages name them.
using ChartTypes = std::vector<ChartType>;

/// Reads "solvers": labels of rows, where the label of a sweep or the name of a family stands for
/// all of its rows. Default: all rows. Throws InputError.
std::vector<std::string> read_row_labels(JsonObject& object, const Experiment& experiment);

/// Reads "solver", the label of a sweep of two parameters. Returns the labels of its rows. Throws
/// InputError.
std::vector<std::string> read_sweep_labels(JsonObject& object, const Experiment& experiment);

/// Reads "metrics", names of metrics, each at most once. Throws InputError.
std::vector<Metric> read_metrics(JsonObject& object, std::vector<Metric> fallback);

/// Reads "charts": objects with a "type", a "name", a "dataset" (default: the first test set) and
/// the keys of their type. Solvers, datasets and timing must have been read. Throws InputError.
std::vector<std::shared_ptr<const Chart>> read_charts(JsonObject& root,
                                                      const Experiment& experiment,
                                                      const ChartTypes& types,
                                                      SolverRegistry& registry);

}  // namespace ertbench
