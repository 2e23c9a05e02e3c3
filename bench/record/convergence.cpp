#include "bench/record/convergence.h"

#include <nlohmann/json.hpp>

namespace ertbench {
namespace {

using nlohmann::json;

void count(const json& parameters, Convergence& convergence) {
  if (!parameters.is_object() || !parameters.contains("training")) return;
  const json& training = parameters.at("training");
  if (!training.is_object() || !training.contains("best_epoch")) return;
  ++convergence.runs;
  const json& best = training.at("best_epoch");
  const json allowed = parameters.value("epochs", json());
  const json said = training.value("converged", json());
  const bool last = best.is_number() && allowed.is_number() && best >= allowed;
  if (said.is_boolean() ? !said.get<bool>() : last) ++convergence.not_converged;
}

}  // namespace

Convergence convergence_of(const ResultRow& row) {
  Convergence convergence;
  if (!row.seeds || row.seeds->parameters->empty()) {
    count(*row.parameters, convergence);
    return convergence;
  }
  for (const json& different : *row.seeds->parameters) {
    json parameters = *row.parameters;
    parameters.update(different);
    count(parameters, convergence);
  }
  return convergence;
}

}  // namespace ertbench
