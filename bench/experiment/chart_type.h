#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

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
