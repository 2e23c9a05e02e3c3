#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/chart.h"
#include "bench/report/heat_map.h"
#include "bench/score/metrics.h"
#include "core/json.h"

namespace ertbench {

/// A sweep of two parameters as a map: `{"type": "heat-map", "name", "solver": the label of the
/// sweep, "metrics", "dataset", "published_optimum": [first, second]}`.
class HeatMapChart : public Chart {
 public:
  static constexpr const char* type = "heat-map";

  /// The published values of both parameters, in their alphabetical order.
  using Optimum = std::pair<JsonValue, JsonValue>;

  explicit HeatMapChart(const ChartRequest& request);
  HeatMapChart(ChartPlace place, std::vector<std::string> labels, std::vector<Metric> metrics,
               std::optional<Optimum> published);

  /// The map that the chart makes of the rows. The best cell is the one with the least mean
  /// relative error of those that are ok.
  HeatMap map_of(std::span<const ResultRow> rows, const std::string& title) const;

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;

 private:
  std::vector<std::string> labels_;  ///< of the sweep's rows
  std::vector<Metric> metrics_;
  std::optional<Optimum> published_;
};

}  // namespace ertbench
