#pragma once

#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/table/table.h"

namespace ertbench {

/// Recommendations (within 1, 5 and 20 % of the least error, and for each budget), the right sizes,
/// and every configuration with its numbers; the text says how to read them.
Table speed_table(const SpeedAccuracy& chart, const std::string& title);

/// The recommendations for programs and pages, one row each: choice, margin or budget_us, label,
/// the median error on the test set with its interval, p50_us and p99_us.
TableSection speed_choices(const SpeedAccuracy& chart);

/// Error against time: `{"type": "speed-accuracy", "name", "solvers", "metric", "dataset",
/// "budgets_us", "break_even_against": [labels]}`. Its tables are also written to `name`.md, its
/// recommendations to `name`_choices.csv and to summary.json under "speed_accuracy".
class SpeedChart : public Chart {
 public:
  static constexpr const char* type = "speed-accuracy";

  explicit SpeedChart(const ChartRequest& request);

  const SpeedQuestion& question() const { return question_; }

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;
  std::string section() const override;
  Table table(std::span<const ResultRow> rows) const override;
  void summarise(std::span<const ResultRow> rows, nlohmann::json& summary) const override;

 private:
  SpeedQuestion question_;
};

}  // namespace ertbench
