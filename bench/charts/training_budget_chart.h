#pragma once

#include <string>

#include "bench/analysis/training_budget.h"
#include "bench/charts/chart.h"

namespace ertbench {

/// Error against what the training cost, a line for each family of networks: `{"type":
/// "training-budget", "name", "solvers", "metric", "dataset", "cost": "seconds" or "scenes"}`.
class TrainingBudgetChart : public Chart {
 public:
  static constexpr const char* type = "training-budget";

  explicit TrainingBudgetChart(const ChartRequest& request);

  const BudgetQuestion& question() const { return question_; }

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;

 private:
  BudgetQuestion question_;
};

}  // namespace ertbench
