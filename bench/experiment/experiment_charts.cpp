#include "bench/experiment/experiment_charts.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/experiment.h"
#include "bench/experiment/names.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::vector<Metric> read_metrics(JsonObject& object, std::vector<Metric> fallback) {
  if (!object.has("metrics")) return fallback;
  std::vector<Metric> out;
  for (const std::string& name : object.choices("metrics", names_of(kMetrics))) {
    const Metric metric = metric_from_name(name);
    if (std::find(out.begin(), out.end(), metric) != out.end()) {
      object.fail("metrics", name + " stands twice; remove one");
    }
    out.push_back(metric);
  }
  return out;
}

/// The labels of the rows that `name` stands for: its own, or all of its sweep.
std::vector<std::string> labels_of(const Experiment& experiment, const std::string& name) {
  std::vector<std::string> out;
  for (const auto& trials : experiment.rows()) {
    const SolverEntry& entry = trials.front();
    if (entry.label == name || entry.family == name) out.push_back(entry.label);
  }
  return out;
}

std::string all_labels(const Experiment& experiment) {
  std::string out;
  for (const auto& trials : experiment.rows()) {
    out += (out.empty() ? "" : ", ") + trials.front().label;
  }
  return out;
}

std::vector<std::string> read_labels(JsonObject& object, const Experiment& experiment) {
  std::vector<std::string> out;
  if (!object.has("solvers")) {
    for (const auto& trials : experiment.rows()) out.push_back(trials.front().label);
    return out;
  }
  const json& names = object.raw("solvers");
  if (!names.is_array() || names.empty()) object.fail("solvers", "must be a list of labels");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string key = std::to_string(i);
    const json holder = {{key, names[i]}};
    JsonObject place(holder, object.source(), object.path_of("solvers"));
    const std::string name = place.text(key);
    const std::vector<std::string> labels = labels_of(experiment, name);
    if (labels.empty()) {
      place.fail(key,
                 "no solver is labelled \"" + name + "\"; there are " + all_labels(experiment));
    }
    for (const std::string& label : labels) {
      if (std::find(out.begin(), out.end(), label) != out.end()) {
        place.fail(key, "\"" + label + "\" stands twice; remove one");
      }
      out.push_back(label);
    }
  }
  return out;
}

/// The labels of a sweep of two parameters.
std::vector<std::string> read_sweep_labels(JsonObject& object, const Experiment& experiment) {
  const std::string name = object.text("solver");
  std::vector<std::string> labels;
  for (const auto& trials : experiment.rows()) {
    const SolverEntry& entry = trials.front();
    const bool two = entry.sweep && entry.sweep->size() == 2;
    if (entry.family == name && two) labels.push_back(entry.label);
  }
  if (labels.empty()) {
    object.fail(
        "solver",
        "must be the label of a solver with a \"sweep\" of two parameters, got \"" + name + "\"");
  }
  return labels;
}

void read_speed_accuracy(JsonObject& object, const Experiment& experiment, ChartSpec& chart) {
  if (!experiment.timing.enabled) {
    object.fail("type", "needs latencies; remove \"enabled\": false from /timing");
  }
  chart.labels = read_labels(object, experiment);
  chart.right_sizing = experiment.right_sizing;
  chart.metrics = {
      metric_from_name(object.choice_or("metric", "relative_error", names_of(kErrorMetrics)))};
  chart.budgets_us = {100, 1000, 10000};
  if (object.has("budgets_us")) {
    const json& values = object.raw("budgets_us");
    const bool positive =
        values.is_array() && std::all_of(values.begin(), values.end(), [](const json& value) {
          return value.is_number() && value > 0;
        });
    if (!positive) object.fail("budgets_us", "must be a list of times in microseconds, all > 0");
    chart.budgets_us = values.get<std::vector<double>>();
  }
  if (object.has("break_even_against")) {
    chart.break_even_against = object.choices("break_even_against", chart.labels);
  } else if (!chart.labels.empty()) {
    for (const auto& trials : experiment.rows()) {
      const SolverEntry& entry = trials.front();
      const bool shown =
          std::find(chart.labels.begin(), chart.labels.end(), entry.label) != chart.labels.end();
      if (!entry.break_even_reference || !shown) continue;
      chart.break_even_against = {entry.label};
      break;
    }
  }
}

ChartSpec read_chart(JsonObject object, const Experiment& experiment) {
  ChartSpec chart;
  const std::string type = object.choice("type", {"bars", "heat-map", "speed-accuracy"});
  chart.name = object.text("name");
  if (!is_name(chart.name)) {
    object.fail("name", "must be made of letters, digits, \"_\" and \"-\" (at most 60), got \"" +
                            chart.name + "\"");
  }
  std::vector<std::string> tests;
  for (const DatasetSpec& test : experiment.tests) tests.push_back(test.name);
  chart.dataset = object.choice_or("dataset", tests.front(), tests);
  if (type == "bars") {
    chart.type = ChartSpec::Type::bars;
    chart.labels = read_labels(object, experiment);
    chart.metrics = read_metrics(object, {kPublishedMetrics.begin(), kPublishedMetrics.end()});
  } else if (type == "speed-accuracy") {
    chart.type = ChartSpec::Type::speed_accuracy;
    read_speed_accuracy(object, experiment, chart);
  } else {
    chart.type = ChartSpec::Type::heat_map;
    chart.labels = read_sweep_labels(object, experiment);
    chart.metrics = read_metrics(object, {Metric::AR, Metric::PE});
    if (object.has("published_optimum")) {
      const json& values = object.raw("published_optimum");
      if (!values.is_array() || values.size() != 2 || values[0].is_structured() ||
          values[1].is_structured()) {
        object.fail("published_optimum",
                    "must be two values, of the swept parameters in alphabetical order");
      }
      chart.published_optimum = {values[0].dump(), values[1].dump()};
    }
  }
  object.finish();
  return chart;
}

}  // namespace

std::vector<ChartSpec> read_charts(JsonObject& root, const Experiment& experiment) {
  std::vector<ChartSpec> charts;
  if (!root.has("charts")) return charts;
  std::set<std::string> names = {"reconstructions"};
  for (const JsonObject& object : root.objects("charts")) {
    charts.push_back(read_chart(object, experiment));
    if (!names.insert(charts.back().name).second) {
      object.fail("name", "\"" + charts.back().name + "\" is taken; give every chart its own name");
    }
  }
  return charts;
}

}  // namespace ertbench
