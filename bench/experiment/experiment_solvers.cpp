#include "bench/experiment/experiment_solvers.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "core/errors.h"
#include "core/lists.h"
#include "core/process.h"
#include "core/text.h"
#include "solvers/registry/plugin.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// The place of a value of a solver's own JSON in the experiment file.
struct Moved {
  std::string from;  ///< "/solvers/0/alpha"
  std::string to;    ///< "/solvers/0/sweep/alpha/1"
};

/// An entry whose solver is constructed once to check its parameters.
struct ReadEntry {
  SolverEntry entry;
  std::vector<Moved> moved;
};

/// One combination of the values of a sweep.
struct SweepPoint {
  std::string label;  ///< " alpha=0.001 beta=0.1", appended to the entry's own; "" for none
  JsonValue values;   ///< `{"alpha": 0.001, "beta": 0.1}`; null for none
  std::vector<std::size_t> indices;  ///< position of each parameter's value in its list
};

bool mentions_auto(const json& value) {
  if (value.is_string()) return value.get_ref<const std::string&>() == "auto";
  return value.is_structured() && std::ranges::any_of(value, mentions_auto);
}

/// Makes the solver of an entry.
void check_solver(const ReadEntry& checked, const Experiment& experiment,
                  SolverRegistry& registry) {
  const SolverEntry& entry = checked.entry;
  const std::string& source = experiment.source;
  JsonObject object(*entry.spec, source, entry.path);
  try {
    const std::unique_ptr<Solver> solver = registry.make(object);
    solver->check(experiment.sensor);
    if (solver->needs_training() && !(experiment.training && experiment.validation)) {
      object.fail("type", entry.type + " is trained; add /datasets/train and /datasets/validation");
    }
    const bool stored = entry.spec->contains("checkpoint");
    if (!experiment.validation && !stored && mentions_auto(solver->parameters())) {
      object.fail("",
                  "a parameter is \"auto\", which is chosen on the validation set; add "
                  "/datasets/validation or give a number");
    }
  } catch (const JsonError& error) {
    for (const Moved& one : checked.moved) {
      if (error.path() == one.from) throw JsonError(source, one.to, error.message());
    }
    throw;
  }
}

/// What a child has to say of one entry: `{}`, `{"refused": ...}` or `{"failed": ...}`.
json said_of(const ReadEntry& checked, const Experiment& experiment, SolverRegistry& registry) {
  try {
    check_solver(checked, experiment, registry);
    return json::object();
  } catch (const InputError& error) {
    return {{"refused", error.what()}};
  } catch (const std::exception& error) {
    return {{"failed", std::string("its constructor threw an exception: ") + error.what()}};
  } catch (...) {
    return {{"failed", "its constructor threw what is no exception"}};
  }
}

Failure failure_of(const ProcessEnd& end) {
  const std::string when = "when it was made to have its parameters checked";
  if (end.timed_out) return {"timed out", when};
  if (end.out_of_memory) return {"out of memory", when};
  if (end.signal != 0) return {"crashed", end.text() + " " + when};
  return {"failed", "it ended its process (" + end.text() + ") " + when};
}

/// Has one child check as many as it survives; returns how many that settled, at least one.
std::size_t check_some(std::span<ReadEntry* const> entries, const Experiment& experiment,
                       SolverRegistry& registry) {
  const double time_s = std::min(plugin_time_limit_s, std::max(experiment.time_limit_s, 5.0));
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        registry.allow_plugins();
        for (const ReadEntry* one : entries) {
          send(json_text(said_of(*one, experiment, registry)));
        }
      },
      {time_s, machine_memory_bytes() / 2});
  for (std::size_t i = 0; i < outcome.messages.size(); ++i) {
    const json said = parse_json(outcome.messages[i], "what a plugin said");
    if (said.contains("refused")) throw InputError(said.at("refused").get<std::string>());
    if (said.contains("failed")) {
      const std::string how = said.at("failed");
      entries[i]->entry.failure = {"failed", printable(how)};
    }
  }
  const std::size_t done = outcome.messages.size();
  if (done == entries.size()) return done;  // whatever became of its process then
  entries[done]->entry.failure = failure_of(outcome.end);
  return done + 1;
}

constexpr std::size_t most_parameters = 2;
constexpr std::size_t most_values = 50;

/// The shortest of "0.001", "1e-07", ... that reads back as the same number.
std::string shortest_text(double value) {
  std::string text;
  for (int digits = 6; digits <= 17; ++digits) {
    text = with_digits(value, digits);
    if (std::strtod(text.c_str(), nullptr) == value) break;
  }
  return text;
}

std::string label_words(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  if (value.is_array()) return joined(value, "-", label_words);
  return shortest_text(value.get<double>());
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
  const bool known = std::ranges::any_of(
      info->parameters, [&](const ParameterInfo& parameter) { return parameter.name == name; });
  if (known) return;
  sweep.fail(name, "is no parameter of this solver; there are " +
                       joined(info->parameters, ", ", &ParameterInfo::name));
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
    const bool numbers = value.is_array() && !value.empty() &&
                         std::ranges::all_of(value, [](const json& v) { return v.is_number(); });
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

/// Reads `"sweep": {"alpha": [1e-4, 1e-3], "beta": [0.1, 1]}` of a solver's entry: one or two of
/// the solver's parameters (in alphabetical order, as the keys of JSON have none), each with 1 to
/// 50 different values: numbers, strings, true or false, lists of numbers. Returns every
/// combination, the last parameter changing fastest; without a sweep one point without values.
/// `info` may be null for a solver whose parameters are not known here. Throws InputError.
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

constexpr std::size_t most_seeds = 100;

std::vector<std::optional<int>> read_seeds(JsonObject& entry, const std::string& type,
                                           const SolverInfo* info) {
  if (!entry.has("seeds")) return {std::nullopt};
  const json& values = entry.raw("seeds");
  if (!values.is_array() || values.empty() || values.size() > most_seeds) {
    entry.fail("seeds", "must be a list of 1 to " + std::to_string(most_seeds) + " whole numbers");
  }
  if (entry.value().contains("seed")) {
    entry.fail("seeds", "stands beside \"seed\"; remove one of the two");
  }
  if (info && !info->has_seed()) {
    entry.fail("seeds", type + " has no training seed; remove it");
  }
  std::vector<std::optional<int>> seeds;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string key = std::to_string(i);
    const json holder = {{key, values[i]}};
    JsonObject place(holder, entry.source(), entry.path_of("seeds"));
    const int seed = place.integer(key, 0, std::numeric_limits<int>::max());
    if (std::ranges::find(seeds, seed) != seeds.end()) {
      place.fail(key, std::to_string(seed) + " stands twice; remove one");
    }
    seeds.emplace_back(seed);
  }
  return seeds;
}

/// Puts the seed in the place of "{seed}" in all texts, such as names of files.
void name_seed(json& value, const std::string& seed) {
  if (value.is_structured()) {
    for (json& one : value) name_seed(one, seed);
  }
  if (value.is_string()) value = replaced(value.get<std::string>(), "{seed}", seed);
}

/// Why an entry of a type that nobody knows cannot be run: a library that could not say what types
/// it has may have this one.
std::optional<Failure> failure_of_type(const SolverRegistry& registry) {
  if (registry.unusable_libraries().empty()) return std::nullopt;
  const auto how = [](const SolverRegistry::UnusableLibrary& library) {
    return library.file.string() + " " + library.how + " when it was loaded";
  };
  return Failure{"failed", joined(registry.unusable_libraries(), "; ", how)};
}

/// Empty where it is none; the entry's reader says so.
std::string type_in(const JsonObject& entry) {
  const json& value = entry.value();
  return value.contains("type") && value.at("type").is_string()
             ? value.at("type").get<std::string>()
             : "";
}

/// One entry of the file at a point of its sweep, for one seed.
SolverEntry entry_of(const JsonObject& object, const std::string& type, const SweepPoint& point,
                     std::optional<int> seed) {
  SolverEntry entry;
  entry.type = type;
  entry.path = object.path_of("");
  entry.seed = seed;
  entry.sweep = point.values;
  json spec = object.value();
  spec.erase("seeds");
  spec.erase("sweep");
  spec.erase("family");
  if (point.values) spec.update(*point.values);
  if (seed) {
    spec["seed"] = *seed;
    name_seed(spec, std::to_string(*seed));
  }
  entry.spec = std::move(spec);
  return entry;
}

/// What of the entry's values stands elsewhere. `seed`: which of "seeds" it has.
std::vector<Moved> moved_values(const JsonObject& object, const SweepPoint& point,
                                std::size_t seed) {
  std::vector<Moved> out = {
      {object.path_of("seed"), object.path_of("seeds") + "/" + std::to_string(seed)}};
  if (!point.values) return out;
  std::size_t i = 0;
  for (const auto& [name, unused] : point.values->items()) {
    const JsonObject sweep(*point.values, "", object.path_of("sweep"));
    out.push_back(
        {object.path_of(name), sweep.path_of(name) + "/" + std::to_string(point.indices[i++])});
  }
  return out;
}

/// One entry of the file as all that it stands for: an entry for each seed at each point of the
/// sweep. `number`: of this entry among those of its type that have no label, from 1.
std::vector<ReadEntry> read_entry(JsonObject object, int number, SolverRegistry& registry,
                                  SolverCheck check) {
  const std::string type = object.text("type");
  const std::string label =
      object.text_or("label", number == 1 ? type : type + "-" + std::to_string(number));
  const std::string family = object.text_or("family", label);
  if (object.has("family") && !is_label(family)) {
    object.fail("family", "must be made of the same characters as a label, got \"" +
                              printable(family) + "\"");
  }
  for (const char* key : {"seeds", "sweep"}) {
    if (!object.has("checkpoint") || !object.has(key)) continue;
    object.fail(key, "has no effect on a solver that is fitted (\"checkpoint\"); remove it");
  }
  const SolverInfo* info =
      check == SolverCheck::all ? registry.find(type) : registry.find_known(type);
  const std::vector<std::optional<int>> seeds = read_seeds(object, type, info);
  std::vector<ReadEntry> entries;
  for (const SweepPoint& point : read_sweep(object, info)) {
    for (std::size_t s = 0; s < seeds.size(); ++s) {
      SolverEntry entry = entry_of(object, type, point, seeds[s]);
      entry.family = family;
      entry.label = label + point.label;
      if (info) describe(entry, *info);
      entries.push_back({std::move(entry), moved_values(object, point, s)});
    }
  }
  return entries;
}

/// Constructs the solvers of all entries, built-in ones here and those of plugins in a child
/// process, so that a solver which ends its process or never returns fails only its own entry
/// (SolverEntry::failure). Throws the first InputError of an entry, with its place in the file.
void check_entries(std::vector<ReadEntry>& entries, const Experiment& experiment,
                   SolverRegistry& registry) {
  std::vector<ReadEntry*> of_plugins;
  for (ReadEntry& one : entries) {
    SolverEntry& entry = one.entry;
    const bool of_plugin = registry.is_of_plugin(entry.type);
    if (!registry.find_known(entry.type)) {
      // An unknown type is refused by the check, unless there is a library that may have it; a
      // plugin of ours that is absent is its trial's failure.
      if (of_plugin) continue;
      entry.failure = failure_of_type(registry);
      if (entry.failure) continue;
    }
    // A damaged file may take the process down that opens it.
    if (of_plugin || entry.spec->contains("checkpoint")) {
      of_plugins.push_back(&one);
    } else {
      check_solver(one, experiment, registry);
    }
  }
  for (std::span<ReadEntry* const> left = of_plugins; !left.empty();) {
    left = left.subspan(check_some(left, experiment, registry));
  }
}

}  // namespace

void describe(SolverEntry& entry, const SolverInfo& info) {
  entry.inference_parameters.clear();
  entry.file_parameters.clear();
  for (const ParameterInfo& parameter : info.parameters) {
    if (parameter.role == ParameterRole::inference) {
      entry.inference_parameters.push_back(parameter.name);
    }
    if (parameter.role == ParameterRole::file) entry.file_parameters.push_back(parameter.name);
  }
  entry.break_even_reference = info.break_even_reference;
}

std::vector<SolverEntry> read_solvers(JsonObject& root, const Experiment& experiment,
                                      SolverRegistry& registry, SolverCheck check) {
  std::vector<ReadEntry> all;
  // Labels, and names of files.
  std::set<std::string> taken = {"truth", "no-contact", "limit-oracle", "limit-fair",
                                 "limit-lower"};
  std::map<std::string, int> unlabelled;  // by type
  for (const JsonObject& object : root.objects("solvers")) {
    const SolverEntry* previous = nullptr;
    const int number = object.value().contains("label") ? 1 : ++unlabelled[type_in(object)];
    std::vector<ReadEntry> entries = read_entry(object, number, registry, check);
    for (const auto& [entry, unused] : entries) {
      if (!is_label(entry.label)) {
        object.fail("label",
                    "must be made of letters, digits, spaces and any of . _ + = , - "
                    "(at most 60, with the values of a sweep), got \"" +
                        entry.label + "\"");
      }
      const bool next_seed = entry.seed && previous && previous->label == entry.label;
      bool free = next_seed || taken.insert(entry.label).second;
      if (entry.seed) free = taken.insert(entry.stem()).second && free;
      if (!free) {
        object.fail("label",
                    "\"" + printable(entry.label) + "\" is taken; give every solver its own label");
      }
      previous = &entry;
    }
    std::ranges::move(entries, std::back_inserter(all));
  }
  if (all.empty()) root.fail("solvers", "must hold at least one solver");
  if (check == SolverCheck::all) check_entries(all, experiment, registry);
  std::vector<SolverEntry> out;
  for (ReadEntry& one : all) out.push_back(std::move(one.entry));
  return out;
}

}  // namespace ertbench
