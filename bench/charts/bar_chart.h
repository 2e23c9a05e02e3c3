#pragma once

#include <string>
#include <vector>

#include "bench/charts/bars.h"
#include "bench/charts/chart.h"
#include "bench/score/metric_table.h"

namespace ertbench {

/// Means of several rows side by side: `{"type": "bars", "name", "solvers": [labels], "metrics",
/// "dataset"}`.
class BarChart : public Chart {
 public:
  static constexpr const char* type = "bars";

  explicit BarChart(const ChartRequest& request);
  BarChart(ChartPlace place, std::vector<std::string> labels, std::vector<Metric> metrics);

  const std::vector<std::string>& labels() const { return labels_; }
  const std::vector<Metric>& metrics() const { return metrics_; }

  /// What the chart shows of the rows.
  Bars bars_of(std::span<const ResultRow> rows, const std::string& title) const;

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;

 private:
  std::vector<std::string> labels_;
  std::vector<Metric> metrics_;
};

}  // namespace ertbench
