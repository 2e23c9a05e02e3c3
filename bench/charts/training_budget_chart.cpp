#include "bench/charts/training_budget_chart.h"

#include "bench/charts/training_budget_figure.h"
#include "bench/experiment/chart_keys.h"
#include "bench/experiment/experiment.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

BudgetQuestion read_question(const ChartRequest& request) {
  JsonObject& object = request.object;
  BudgetQuestion question;
  question.dataset = request.place.dataset;
  question.labels = read_row_labels(object, request.experiment);
  question.metric = metric_from_name(
      object.choice_or("metric", name_of(question.metric), names_of(kErrorMetrics)));
  if (object.choice_or("cost", "seconds", {"seconds", "scenes"}) == "scenes") {
    question.cost = TrainingCost::scenes;
  }
  return question;
}

}  // namespace

TrainingBudgetChart::TrainingBudgetChart(const ChartRequest& request)
    : Chart(request.place), question_(read_question(request)) {}

void TrainingBudgetChart::draw(std::span<const ResultRow> rows, const std::string& title,
                               const std::filesystem::path& folder) const {
  draw_training_budgets(training_budgets_of(question_, rows), title, folder / name());
}

std::string TrainingBudgetChart::caption() const {
  return "means of the " + axis_title(question_.metric) + " with their 95 % intervals over " +
         (question_.cost == TrainingCost::seconds ? "the time of the training"
                                                  : "the scenes seen in training") +
         ", test set " + dataset();
}

}  // namespace ertbench
