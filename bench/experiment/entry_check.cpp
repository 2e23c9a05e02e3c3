#include "bench/experiment/entry_check.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "core/json_text.h"
#include "core/process.h"
#include "core/text.h"
#include "solvers/registry/plugin_description.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

bool mentions_auto(const json& value) {
  if (value.is_string()) return value.get_ref<const std::string&>() == "auto";
  return value.is_structured() && std::any_of(value.begin(), value.end(), mentions_auto);
}

/// Makes the solver of an entry.
void check_solver(const EntryToCheck& checked, const Experiment& experiment,
                  SolverRegistry& registry) {
  const SolverEntry& entry = *checked.entry;
  const std::string& source = experiment.source;
  JsonObject object(*entry.spec, source, entry.path);
  try {
    const std::unique_ptr<Solver> solver = registry.make(object);
    solver->check(experiment.sensor);
    if (solver->needs_training() && !(experiment.training && experiment.validation)) {
      object.fail("type", entry.type + " is trained; add /datasets/train and /datasets/validation");
    }
    if (!experiment.validation && mentions_auto(solver->parameters())) {
      object.fail("",
                  "a parameter is \"auto\", which is chosen on the validation set; add "
                  "/datasets/validation or give a number");
    }
  } catch (const InputError& error) {
    const std::string message = error.what();
    for (const Moved& one : checked.moved) {
      const std::string start = source + ": " + one.from + ":";
      if (message.starts_with(start)) {
        throw InputError(source + ": " + one.to + ":" + message.substr(start.size()));
      }
    }
    throw;
  }
}

/// What a child has to say of one entry: `{}`, `{"refused": ...}` or `{"failed": ...}`.
json said_of(const EntryToCheck& checked, const Experiment& experiment, SolverRegistry& registry) {
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
std::size_t check_some(std::span<const EntryToCheck> entries, const Experiment& experiment,
                       SolverRegistry& registry) {
  const double time_s = std::min(plugin_time_limit_s, std::max(experiment.time_limit_s, 5.0));
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        registry.allow_plugins();
        for (const EntryToCheck& one : entries) {
          send(json_text(said_of(one, experiment, registry)));
        }
      },
      {time_s, machine_memory_bytes() / 2});
  for (std::size_t i = 0; i < outcome.messages.size(); ++i) {
    const json said = parse_json(outcome.messages[i], "what a plugin said");
    if (said.contains("refused")) throw InputError(said.at("refused").get<std::string>());
    if (said.contains("failed")) {
      const std::string how = said.at("failed");
      entries[i].entry->failure = {"failed", printable(how)};
    }
  }
  const std::size_t done = outcome.messages.size();
  if (done == entries.size()) return done;  // whatever became of its process then
  entries[done].entry->failure = failure_of(outcome.end);
  return done + 1;
}

}  // namespace

void check_entries(std::span<const EntryToCheck> entries, const Experiment& experiment,
                   SolverRegistry& registry) {
  std::vector<EntryToCheck> of_plugins;
  for (const EntryToCheck& one : entries) {
    if (registry.is_of_plugin(one.entry->type)) {
      of_plugins.push_back(one);
    } else {
      check_solver(one, experiment, registry);
    }
  }
  for (std::span<const EntryToCheck> left = of_plugins; !left.empty();) {
    left = left.subspan(check_some(left, experiment, registry));
  }
}

}  // namespace ertbench
