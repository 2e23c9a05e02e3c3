#include "bench/experiment/sweep.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "bench/experiment/names.h"
#include "core/json_reader.h"
#include "core/json_text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr std::size_t most_parameters = 2;
constexpr std::size_t most_values = 50;

/// The shortest of "0.001", "1e-07", ... that reads back as the same number.
std::string number_text(double value) {
  char text[64];
  for (int digits = 6; digits <= 17; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  return text;
}

std::string label_words(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  if (value.is_array()) {
    std::string text;
    for (const json& one : value) text += (text.empty() ? "" : "-") + label_words(one);
    return text;
  }
  return number_text(value.get<double>());
}

void check_parameter(const JsonObject& sweep, const std::string& name, const JsonObject& entry,
                     const SolverInfo* info) {
  for (const char* key : {"type", "label", "family", "seeds", "sweep"}) {
    if (name == key) sweep.fail(name, "cannot be swept; name a parameter of the solver");
  }
  if (name == "seed") sweep.fail(name, "is not swept; give the entry \"seeds\": [1, 2, 3]");
  if (entry.value().contains(name)) {
    sweep.fail(name, "stands in the entry as well, at " + entry.path_of(name) + "; remove one");
  }
  if (!info) return;
  const bool known =
      std::any_of(info->parameters.begin(), info->parameters.end(),
                  [&](const ParameterInfo& parameter) { return parameter.name == name; });
  if (known) return;
  std::string all;
  for (const auto& parameter : info->parameters) all += (all.empty() ? "" : ", ") + parameter.name;
  sweep.fail(name, "is no parameter of this solver; there are " + all);
}

/// Checks one list of values.
void check_values(const json& values, JsonObject& sweep, const std::string& name) {
  if (!values.is_array() || values.empty() || values.size() > most_values) {
    sweep.fail(name, "must be a list of 1 to " + std::to_string(most_values) + " values");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto fail = [&](const std::string& message) {
      const json holder = json::object();
      JsonObject(holder, sweep.source(), sweep.path_of(name)).fail(std::to_string(i), message);
    };
    const json& value = values[i];
    const bool numbers =
        value.is_array() && !value.empty() &&
        std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
    if (!value.is_number() && !value.is_string() && !value.is_boolean() && !numbers) {
      fail("must be a number, a string, true or false, or a list of numbers, got " +
           json_shown(value));
    }
    if (value.is_string() && !is_label_text(value.get_ref<const std::string&>())) {
      fail(
          "becomes part of a label: must be made of letters, digits, spaces and any of . _ + = , "
          "-");
    }
    const auto here = values.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(values.begin(), here, value) != here) {
      fail(json_shown(value) + " stands twice; remove one");
    }
  }
}

}  // namespace

std::vector<SweepPoint> read_sweep(JsonObject& entry, const SolverInfo* info) {
  if (!entry.has("sweep")) return {SweepPoint{}};
  JsonObject sweep = entry.object("sweep");
  const std::vector<std::string> names = sweep.keys();
  if (names.empty() || names.size() > most_parameters) {
    entry.fail("sweep", "must name one or two parameters of the solver");
  }
  std::vector<SweepPoint> points = {SweepPoint{}};
  for (const std::string& name : names) {
    check_parameter(sweep, name, entry, info);
    const json& values = sweep.raw(name);
    check_values(values, sweep, name);
    std::vector<SweepPoint> longer;
    for (const SweepPoint& point : points) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        SweepPoint next = point;
        next.label += " " + name + "=" + label_words(values[i]);
        json all = point.values ? *point.values : json::object();
        all[name] = values[i];
        next.values = std::move(all);
        next.indices.push_back(i);
        longer.push_back(std::move(next));
      }
    }
    points = std::move(longer);
  }
  return points;
}

}  // namespace ertbench
