#include "bench/experiment/ladder_spec.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "core/errors.h"
#include "core/fields.h"
#include "core/lists.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::string level_words(const json& value) {
  if (value.is_number()) return with_digits(value.get<double>(), 5);
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return json_text(value);
  return joined(value, ", ", level_words);
}

constexpr std::size_t most_levels = 100;
const std::string training_prefix = "train:";

bool is_of_training(const std::string& pointer) { return pointer.starts_with(training_prefix); }

/// Puts the values of `set` and the level into a copy of `base`: those of the training set, or the
/// others.
json varied(const JsonValue& base, const LadderAxis& axis, const Level& level, bool training) {
  json out = *base;
  const auto put = [&](const std::string& pointer, const json& value) {
    if (is_of_training(pointer) != training) return;
    const std::string own = training ? pointer.substr(training_prefix.size()) : pointer;
    try {
      out[json::json_pointer(own)] = value;
    } catch (const json::exception&) {
      throw InputError("\"" + printable(pointer) +
                       "\" leads nowhere; a pointer is like \"/scenes/radius\"");
    }
  };
  for (const auto& [pointer, value] : axis.set) put(pointer, *value);
  for (const std::string& pointer : axis.vary) put(pointer, level.json());
  for (const auto& [pointer, values] : axis.together) {
    const auto at = std::ranges::find_if(
        axis.levels, [&](const Level& one) { return one.json() == level.json(); });
    put(pointer, values->at(static_cast<std::size_t>(at - axis.levels.begin())));
  }
  return out;
}

void visit(Fields& fields, FailureRule& rule) {
  fields.number("relative_error", rule.relative_error, {0, 1e6, true});
  fields.number("distance", rule.distance, {0, 3});
  fields.number("contact_threshold", rule.contact_threshold, {0, 1e6, true});
  fields.number("share", rule.share, {0, 0.99});
}

/// Strings out of one string or a list of them.
std::vector<std::string> read_strings(JsonObject& object, const char* key) {
  const json& value = object.raw(key);
  if (value.is_string()) return {value.get<std::string>()};
  const bool strings = value.is_array() && !value.empty() &&
                       std::ranges::all_of(value, [](const json& one) { return one.is_string(); });
  if (!strings) object.fail(key, "must be a string or a list of strings, got " + json_shown(value));
  return value.get<std::vector<std::string>>();
}

/// "vary": pointers that get the level, or {POINTER: [values], ...}, a value for each level, which
/// has no levels between.
void read_varied(JsonObject& object, LadderAxis& axis) {
  if (!object.raw("vary").is_object()) {
    axis.vary = read_strings(object, "vary");
    return;
  }
  JsonObject together = object.object("vary");
  if (!axis.categories) {
    object.fail("vary", R"(with a value for each level needs "scale": "categories")");
  }
  for (const std::string& pointer : together.keys()) {
    const json& values = together.raw(pointer);
    if (!values.is_array() || values.size() != object.raw("levels").size()) {
      together.fail(pointer, "must be a list of as many values as there are \"levels\"");
    }
    axis.together.emplace_back(pointer, values);
  }
}

void read_levels(JsonObject& object, LadderAxis& axis) {
  const json& levels = object.raw("levels");
  const std::size_t least = axis.categories ? 1 : 2;
  if (!levels.is_array() || levels.size() < least || levels.size() > most_levels) {
    object.fail("levels", "must be a list of " + std::to_string(least) + " to " +
                              std::to_string(most_levels) + " levels");
  }
  for (std::size_t i = 0; i < levels.size(); ++i) {
    axis.levels.emplace_back(levels[i]);
    if (axis.categories) continue;
    const std::string level = "level " + std::to_string(i);
    if (!levels[i].is_number()) {
      object.fail(
          "levels",
          level + R"( must be a number; levels without an order have "scale": "categories")");
    }
    const double value = levels[i];
    if (axis.logarithmic && value <= 0) {
      object.fail("levels", level + R"( must be > 0 on a "log" scale)");
    }
    if (axis.integer && value != static_cast<double>(static_cast<long long>(value))) {
      object.fail("levels", level + " must be a whole number");
    }
    if (i == 0) continue;
    const double step = value - levels[i - 1].get<double>();
    const bool rises = levels[1] > levels[0];
    if (rises ? step <= 0 : step >= 0) {
      object.fail("levels", "must rise, or fall, throughout, from the mildest to the severest");
    }
  }
}

/// The solvers whose parameter it is, and whether the parameter exists.
void read_axis_solvers(JsonObject& object, const Experiment& experiment, SolverRegistry& registry,
                       SolverCheck check, LadderAxis& axis) {
  if (!object.has("solver")) {
    for (const std::string& pointer : axis.vary) {
      if (is_of_training(pointer)) {
        object.fail("vary", R"(changes the training set; name the "solver" that is trained on it)");
      }
    }
    return;
  }
  axis.solvers = read_strings(object, "solver");
  for (const std::string& label : axis.solvers) {
    const auto entry = std::ranges::find(experiment.solvers, label, &SolverEntry::label);
    if (entry == experiment.solvers.end()) {
      object.fail("solver", "no solver is labelled \"" + printable(label) + "\"");
    }
    if (entry->spec->contains("checkpoint")) {
      object.fail("solver", "\"" + label + "\" is fitted (\"checkpoint\"); name another");
    }
    const SolverInfo* info = check == SolverCheck::all ? registry.find(entry->type) : nullptr;
    for (const std::string& pointer : axis.vary) {
      if (is_of_training(pointer)) {
        if (!experiment.training) object.fail("vary", "there is no /datasets/train");
        if (experiment.training->measured()) {
          object.fail("vary", "/datasets/train was measured, and cannot be generated otherwise");
        }
        continue;
      }
      const std::string key =
          pointer.substr(0, pointer.find('/', 1)).substr(pointer.empty() ? 0 : 1);
      const bool known =
          !info || std::ranges::any_of(info->parameters,
                                       [&](const ParameterInfo& p) { return p.name == key; });
      if (!known)
        object.fail("vary", "\"" + printable(key) + "\" is no parameter of " + entry->type);
    }
  }
}

LadderAxis read_axis(JsonObject object, const Experiment& experiment, SolverRegistry& registry,
                     SolverCheck check) {
  LadderAxis axis;
  axis.spec = object.value();
  axis.name = object.text("name");
  if (!is_name(axis.name)) {
    object.fail("name", "must be made of letters, digits, \"_\" and \"-\" (at most 60), got \"" +
                            axis.name + "\"");
  }
  axis.title = object.text_or("title", axis.name);
  axis.unit = object.text_or("unit", "");
  if (object.has("set")) {
    JsonObject set = object.object("set");
    for (const std::string& pointer : set.keys()) {
      axis.set.emplace_back(pointer, set.raw(pointer));
    }
  }
  const std::string scale = object.choice_or("scale", "linear", {"linear", "log", "categories"});
  axis.categories = scale == "categories";
  axis.logarithmic = scale == "log";
  read_varied(object, axis);
  axis.integer = object.boolean_or("integer", false);
  read_levels(object, axis);
  read_axis_solvers(object, experiment, registry, check, axis);
  object.finish();
  return axis;
}

}  // namespace

Level::Level(double number) : value_(nlohmann::json(number)) {}

Level::Level(int number) : value_(nlohmann::json(number)) {}

Level::Level(nlohmann::json value) : value_(std::move(value)) {}

bool Level::is_number() const { return json().is_number(); }

double Level::number() const {
  if (!is_number()) throw std::logic_error("the level " + json_text(json()) + " is not a number");
  return json().get<double>();
}

std::string Level::text() const { return level_words(json()); }

bool LadderAxis::concerns(const SolverEntry& entry) const {
  return solvers.empty() || std::ranges::find(solvers, entry.label) != solvers.end();
}

std::optional<Ladders> read_ladders(JsonObject& root, const Experiment& experiment,
                                    SolverRegistry& registry, SolverCheck check) {
  if (!root.has("ladders")) return std::nullopt;
  JsonObject object = root.object("ladders");
  Ladders ladders;
  const std::vector<std::string> tests = distinct(experiment.tests, &DatasetSpec::name);
  ladders.dataset = object.choice_or("dataset", tests.front(), tests);
  const json& datasets = root.value().at("datasets");
  if (experiment.find_dataset(ladders.dataset)->measured()) {
    object.fail("dataset", "\"" + ladders.dataset +
                               "\" was measured, and its levels are to be generated; name a "
                               "generated test set");
  }
  ladders.base = datasets.at(ladders.dataset);
  if (experiment.training && !experiment.training->measured()) {
    ladders.training = datasets.at("train");
  }
  Fields::read_some(object, [&](Fields& fields) {
    fields.object("failure", [&](Fields& failure) { visit(failure, ladders.failure); });
  });
  std::set<std::string> names;
  for (const JsonObject& one : object.objects("axes")) {
    LadderAxis axis = read_axis(one, experiment, registry, check);
    if (!names.insert(axis.name).second) {
      one.fail("name", "\"" + printable(axis.name) + "\" is taken; give every axis its own name");
    }
    for (std::size_t i = 0; i < axis.levels.size(); ++i) {
      try {
        if (axis.of_parameter()) {
          training_at(ladders, experiment.sensor, axis, axis.levels[i]);
        } else {
          dataset_at(ladders, experiment.sensor, axis, axis.levels[i]);
        }
      } catch (const InputError& error) {
        one.fail("levels", "level " + std::to_string(i) + ", " + json_shown(axis.levels[i].json()) +
                               ", makes what cannot be used: " + error.what());
      }
    }
    ladders.axes.push_back(std::move(axis));
  }
  if (ladders.axes.empty()) object.fail("axes", "must hold at least one axis");
  object.finish();
  return ladders;
}

nlohmann::ordered_json ladder_settings_schema() {
  FailureRule rule;
  return Fields::schema([&](Fields& fields) {
    fields.object("failure", [&](Fields& failure) { visit(failure, rule); });
  });
}

DatasetSpec dataset_at(const Ladders& ladders, const Sensor& sensor, const LadderAxis& axis,
                       const Level& level) {
  const json object = varied(ladders.base, axis, level, false);
  return dataset_spec_from_json(JsonObject(object, "", "/datasets/" + ladders.dataset), sensor,
                                ladders.dataset);
}

SolverEntry entry_at(const SolverEntry& entry, const LadderAxis& axis, const Level& level) {
  SolverEntry out = entry;
  out.spec = varied(entry.spec, axis, level, false);
  return out;
}

std::optional<DatasetSpec> training_at(const Ladders& ladders, const Sensor& sensor,
                                       const LadderAxis& axis, const Level& level) {
  if (!ladders.training) return std::nullopt;
  const json object = varied(ladders.training, axis, level, true);
  return dataset_spec_from_json(JsonObject(object, "", "/datasets/train"), sensor, "train");
}

}  // namespace ertbench
