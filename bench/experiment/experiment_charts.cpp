#include "bench/experiment/experiment_charts.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// The labels of the rows that `name` stands for: its own, or all of its sweep.
std::vector<std::string> labels_of(const Experiment& experiment, const std::string& name) {
  std::vector<std::string> out;
  for (const auto& trials : experiment.rows()) {
    if (trials.front().is_named(name)) out.push_back(trials.front().label);
  }
  return out;
}

std::vector<std::string> all_labels(const Experiment& experiment) {
  return distinct(experiment.solvers, &SolverEntry::label);
}

const ChartType& read_type(JsonObject& object, const ChartTypes& types) {
  const std::string name = object.choice("type", distinct(types, &ChartType::name));
  return *std::ranges::find(types, name, &ChartType::name);
}

ChartPlace read_place(JsonObject& object, const Experiment& experiment) {
  ChartPlace place;
  place.name = object.text("name");
  if (!is_name(place.name)) {
    object.fail("name", "must be made of letters, digits, \"_\" and \"-\" (at most 60), got \"" +
                            place.name + "\"");
  }
  const std::vector<std::string> tests = distinct(experiment.tests, &DatasetSpec::name);
  place.dataset = object.choice_or("dataset", tests.front(), tests);
  return place;
}

}  // namespace

std::vector<std::string> read_row_labels(JsonObject& object, const Experiment& experiment) {
  if (!object.has("solvers")) return all_labels(experiment);
  std::vector<std::string> out;
  const json& names = object.raw("solvers");
  if (!names.is_array() || names.empty()) object.fail("solvers", "must be a list of labels");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string key = std::to_string(i);
    const json holder = {{key, names[i]}};
    JsonObject place(holder, object.source(), object.path_of("solvers"));
    const std::string name = place.text(key);
    const std::vector<std::string> labels = labels_of(experiment, name);
    if (labels.empty()) {
      place.fail(key, "no solver is labelled \"" + printable(name) + "\"; there are " +
                          joined(all_labels(experiment)));
    }
    for (const std::string& label : labels) {
      if (std::ranges::find(out, label) != out.end()) {
        place.fail(key, "\"" + label + "\" stands twice; remove one");
      }
      out.push_back(label);
    }
  }
  return out;
}

std::vector<std::string> read_sweep_labels(JsonObject& object, const Experiment& experiment) {
  const std::string name = object.text("solver");
  std::vector<std::string> labels;
  for (const auto& trials : experiment.rows()) {
    const SolverEntry& entry = trials.front();
    const bool two = entry.sweep && entry.sweep->size() == 2;
    if (entry.family == name && two) labels.push_back(entry.label);
  }
  if (labels.empty()) {
    object.fail("solver",
                "must be the label of a solver with a \"sweep\" of two parameters, got \"" +
                    printable(name) + "\"");
  }
  return labels;
}

std::vector<Metric> read_metrics(JsonObject& object, std::vector<Metric> fallback) {
  if (!object.has("metrics")) return fallback;
  std::vector<Metric> out;
  for (const std::string& name : object.choices("metrics", accepted_names(kMetrics))) {
    const Metric metric = metric_from_name(name);
    if (std::ranges::find(out, metric) != out.end()) {
      object.fail("metrics", name + " stands twice; remove one");
    }
    out.push_back(metric);
  }
  return out;
}

std::vector<std::shared_ptr<const Chart>> read_charts(JsonObject& root,
                                                      const Experiment& experiment,
                                                      const ChartTypes& types,
                                                      SolverRegistry& registry) {
  std::vector<std::shared_ptr<const Chart>> charts;
  std::set<std::string> taken = {"reconstructions"};
  for (JsonObject& object : root.objects("charts")) {
    const ChartType& type = read_type(object, types);
    const ChartPlace place = read_place(object, experiment);
    charts.push_back(type.read({object, place, experiment, registry}));
    object.finish();
    if (!taken.insert(place.name).second) {
      object.fail("name", "\"" + place.name + "\" is taken; give every chart its own name");
    }
  }
  return charts;
}

}  // namespace ertbench
