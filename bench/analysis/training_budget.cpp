#include "bench/analysis/training_budget.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/record/convergence.h"
#include "core/moments.h"

namespace ertbench {
namespace {

using nlohmann::json;

const ResultRow* row_named(std::span<const ResultRow> rows, const std::string& label,
                           const std::string& dataset) {
  for (const ResultRow& row : rows) {
    if (row.label == label && row.dataset == dataset) return &row;
  }
  return nullptr;
}

/// Epochs times scenes of one training; none where it does not say them.
std::optional<double> scenes_seen(const json& parameters) {
  const json training = parameters.is_object() ? parameters.value("training", json()) : json();
  if (!training.is_object()) return std::nullopt;
  const json epochs = training.value("epochs", json());
  const json scenes = training.value("scenes", json());
  if (!epochs.is_number() || !scenes.is_number()) return std::nullopt;
  return epochs.get<double>() * scenes.get<double>();
}

std::optional<double> mean_scenes_seen(const ResultRow& row) {
  std::vector<double> seen;
  const auto add = [&](const json& parameters) {
    if (const auto scenes = scenes_seen(parameters)) seen.push_back(*scenes);
  };
  if (row.seeds) {
    for (const json& different : *row.seeds->parameters) add(different);
  }
  if (seen.empty()) add(*row.parameters);
  return seen.empty() ? std::nullopt : std::optional(mean(seen));
}

/// Why a row has no point; empty where it has one.
std::string reason_of(const ResultRow* row, const std::optional<double>& cost, Metric metric) {
  if (!row) return "not run";
  if (!row->ok()) return row->status;
  if (convergence_of(*row).runs == 0 || !cost || *cost <= 0) return "not trained";
  return row->metrics[metric].mean ? "" : "no error";
}

BudgetLine& line_of(std::vector<BudgetLine>& lines, const std::string& family) {
  const auto found = std::find_if(lines.begin(), lines.end(),
                                  [&](const BudgetLine& line) { return line.family == family; });
  if (found != lines.end()) return *found;
  lines.push_back({family, {}});
  return lines.back();
}

}  // namespace

TrainingBudgets training_budgets_of(const BudgetQuestion& question,
                                    std::span<const ResultRow> rows) {
  TrainingBudgets out;
  out.metric = question.metric;
  out.cost = question.cost;
  for (const std::string& label : question.labels) {
    const ResultRow* row = row_named(rows, label, question.dataset);
    const bool seconds = question.cost == TrainingCost::seconds;
    const std::optional<double> cost = !row      ? std::nullopt
                                       : seconds ? row->fit_s
                                                 : mean_scenes_seen(*row);
    if (const std::string reason = reason_of(row, cost, question.metric); !reason.empty()) {
      out.without.emplace_back(label, reason);
      continue;
    }
    const MetricSummary& summary = row->metrics[question.metric];
    line_of(out.lines, row->family.empty() ? label : row->family)
        .points.push_back({label, *cost, *summary.mean, summary.ci95, convergence_of(*row).all()});
  }
  for (BudgetLine& line : out.lines) {
    std::stable_sort(line.points.begin(), line.points.end(),
                     [](const BudgetPoint& a, const BudgetPoint& b) { return a.cost < b.cost; });
  }
  if (const ResultRow* nothing = row_named(rows, "no-contact", question.dataset)) {
    out.nothing = nothing->metrics[question.metric].mean;
  }
  return out;
}

}  // namespace ertbench
