#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/metrics.h"

namespace ertbench {

/// A chart that an experiment asks for, drawn into the result folder as `name`.svg and .png.
struct ChartSpec {
  enum class Type { bars, heat_map };

  Type type = Type::bars;
  std::string name;
  std::string dataset;              ///< test set
  std::vector<std::string> labels;  ///< of the rows, in order; of a heat map those of its sweep
  std::vector<Metric> metrics;
  /// Of a heat map: JSON texts of the published values of both parameters, in their order.
  std::optional<std::pair<std::string, std::string>> published_optimum;
};

}  // namespace ertbench
