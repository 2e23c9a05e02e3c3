#include "bench/charts/speed_chart.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/analysis/speed_tables.h"
#include "bench/charts/speed_figure.h"
#include "bench/experiment/chart_keys.h"
#include "bench/experiment/experiment.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/json_reader.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::vector<double> read_budgets(JsonObject& object) {
  if (!object.has("budgets_us")) return {100, 1000, 10000};
  const json& values = object.raw("budgets_us");
  const bool positive =
      values.is_array() && std::all_of(values.begin(), values.end(), [](const json& value) {
        return value.is_number() && value > 0;
      });
  if (!positive) object.fail("budgets_us", "must be a list of times in microseconds, all > 0");
  return values.get<std::vector<double>>();
}

/// By default the first row that is shown and whose type is registered as a reference for the
/// break-even.
std::vector<std::string> read_references(const ChartRequest& request,
                                         const std::vector<std::string>& labels) {
  if (request.object.has("break_even_against")) {
    return request.object.choices("break_even_against", labels);
  }
  for (const auto& trials : request.experiment.rows()) {
    const SolverEntry& entry = trials.front();
    if (std::find(labels.begin(), labels.end(), entry.label) == labels.end()) continue;
    if (entry.break_even_reference) return {entry.label};
  }
  return {};
}

SpeedQuestion read_question(const ChartRequest& request) {
  JsonObject& object = request.object;
  if (!request.experiment.timing.enabled) {
    object.fail("type", "needs latencies; remove \"enabled\": false from /timing");
  }
  SpeedQuestion question;
  question.dataset = request.place.dataset;
  question.labels = read_row_labels(object, request.experiment);
  question.metric = metric_from_name(
      object.choice_or("metric", name_of(question.metric), names_of(kErrorMetrics)));
  question.budgets_us = read_budgets(object);
  question.right_sizing = request.experiment.right_sizing;
  question.break_even_against = read_references(request, question.labels);
  return question;
}

}  // namespace

SpeedChart::SpeedChart(const ChartRequest& request)
    : Chart(request.place), question_(read_question(request)) {}

void SpeedChart::draw(std::span<const ResultRow> rows, const std::string& title,
                      const std::filesystem::path& folder) const {
  const SpeedAccuracy answer = speed_accuracy_of(question_, rows);
  draw_speed_figure(answer, title, folder / name());
  write_file_atomically(folder / (name() + ".md"), markdown_of(speed_table(answer, title)));
  write_file_atomically(folder / (name() + "_choices.csv"), csv_of(speed_choices(answer)));
}

std::string SpeedChart::caption() const {
  return "medians of the " + axis_title(question_.metric) + " over the time of a frame, test set " +
         dataset();
}

std::string SpeedChart::section() const { return "Speed and accuracy: " + dataset(); }

std::string SpeedChart::notes(std::span<const ResultRow> rows) const {
  return speed_table(speed_accuracy_of(question_, rows), "").text;
}

std::vector<TableSection> SpeedChart::tables(std::span<const ResultRow> rows) const {
  return speed_table(speed_accuracy_of(question_, rows), "").sections;
}

void SpeedChart::summarise(std::span<const ResultRow> rows, json& summary) const {
  summary["speed_accuracy"][name()] = to_json(speed_accuracy_of(question_, rows));
}

}  // namespace ertbench
