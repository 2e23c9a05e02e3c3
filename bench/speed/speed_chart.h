#pragma once

#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/table/table.h"

namespace ertbench {

/// What to take (within 1, 5 and 20 % of the least error, and for each budget), the right sizes,
/// and every configuration with its numbers; above them how they are to be read.
Table speed_table(const SpeedAccuracy& chart, const std::string& title);

/// What to take, for programs and pages: choice, margin or budget_us, label, the median error on
/// the test set with its interval, p50_us and p99_us; a row for every choice of the first table.
TableSection speed_choices(const SpeedAccuracy& chart);

/// Error against time, with the tables that belong to it: `{"type": "speed-accuracy", "name",
/// "solvers", "metric", "dataset", "budgets_us", "break_even_against": [labels]}`. Its tables also
/// stand in `name`.md, what it recommends in `name`_choices.csv and in summary.json under
/// "speed_accuracy".
class SpeedChart : public Chart {
 public:
  static constexpr const char* type = "speed-accuracy";

  explicit SpeedChart(const ChartRequest& request);

  const SpeedQuestion& question() const { return question_; }

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;
  std::string section() const override;
  std::string notes(std::span<const ResultRow> rows) const override;
  std::vector<TableSection> tables(std::span<const ResultRow> rows) const override;
  void summarise(std::span<const ResultRow> rows, nlohmann::json& summary) const override;

 private:
  SpeedQuestion question_;
};

}  // namespace ertbench
