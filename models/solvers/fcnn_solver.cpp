#include "models/networks/fcnn.h"
#include "models/solvers/solvers.h"

namespace ertbench {

void FcnnSolver::read(JsonObject object) {
  if (object.has("widths")) widths_ = object.integers("widths", 1, 16, {1, 65536});
  training_ = TrainingSettings::from_json(object, {});
  object.finish();
}

nlohmann::json FcnnSolver::settings() const { return {{"widths", widths_}}; }

std::shared_ptr<Network> FcnnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<Fcnn>(sensor, widths_);
}

std::unique_ptr<Objective> FcnnSolver::make_objective(const FitInput&) const {
  return std::make_unique<SquaredError>();
}

}  // namespace ertbench
