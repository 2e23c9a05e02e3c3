#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/record/result_row.h"
#include "bench/report/chart.h"

namespace ertbench {

/// Unit of the cost of a training.
enum class TrainingCost {
  seconds,  ///< duration of the whole fit
  scenes,   ///< scenes seen by the network, counted in every epoch
};

struct BudgetQuestion {
  std::string dataset;
  std::vector<std::string> labels;  ///< of the rows, in order
  Metric metric = Metric::relative_error;
  TrainingCost cost = TrainingCost::seconds;
};

/// A network trained at one budget.
struct BudgetPoint {
  std::string label;
  double cost = 0;               ///< mean over the seeds
  double error = 0;              ///< mean over the frames
  std::optional<Interval> ci95;  ///< of that mean
  Interval trainings = {};       ///< from the least to the largest mean of one training
  bool converged = true;         ///< false if a seed's best epoch was its last (Convergence)
};

/// One network at all its budgets.
struct BudgetLine {
  std::string family;
  std::vector<BudgetPoint> points;  ///< from the cheapest to the dearest

  /// By what part the error changed over the last doubling of the cost, negative where it fell, as
  /// the straight line of logarithms between the last two points has it; nothing with one point.
  std::optional<double> last_doubling() const;
  /// Whether that was less than flat_below: more training of the same kind buys nothing to speak
  /// of.
  bool flat() const;

  static constexpr double flat_below = 0.01;
};

/// Error against training cost.
struct TrainingBudgets {
  Metric metric = Metric::relative_error;
  TrainingCost cost = TrainingCost::seconds;
  std::vector<BudgetLine> lines;                             ///< in the order of the rows
  std::vector<std::pair<std::string, std::string>> without;  ///< labels without a point, and why
  std::optional<double> nothing;  ///< the error of the image without contact
};

/// Evaluates the rows asked for; those of one family make a line. Rows that failed or were not
/// trained are listed in `without`.
TrainingBudgets training_budgets_of(const BudgetQuestion& question,
                                    std::span<const ResultRow> rows);

/// Draws `stem`.svg and `stem`.png: the error against the cost of the training (logarithmic), with
/// one line for each family, named at its end, and hollow marks where the training had not
/// converged. Rows without a point are listed in a corner. Throws InputError if gnuplot is missing
/// or a file cannot be written.
void draw_training_budgets(const TrainingBudgets& budgets, const std::string& title,
                           const std::filesystem::path& stem);

/// Error against the cost of the training, one line per family of networks: `{"type":
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
