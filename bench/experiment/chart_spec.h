#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/right_sizing.h"
#include "bench/score/metrics.h"

namespace ertbench {

/// A chart that an experiment asks for, drawn into the result folder as `name`.svg and .png.
struct ChartSpec {
  enum class Type { bars, heat_map, speed_accuracy };

  Type type = Type::bars;
  std::string name;
  std::string dataset;              ///< test set
  std::vector<std::string> labels;  ///< of the rows, in order; of a heat map those of its sweep
  std::vector<Metric> metrics;
  /// Of a heat map: JSON texts of the published values of both parameters, in their order.
  std::optional<std::pair<std::string, std::string>> published_optimum;
  // Of a chart of speed and accuracy, which has one metric:
  std::vector<double> budgets_us;               ///< for one frame; the method to take for each
  std::optional<RightSizing> right_sizing;      ///< the experiment's
  std::vector<std::string> break_even_against;  ///< labels that longer fits are held against
};

}  // namespace ertbench
