#include "models/networks/dcnn.h"
#include "models/solvers/solvers.h"

namespace ertbench {

void DcnnSolver::check(const Sensor& sensor) const { Dcnn::check(sensor); }

void DcnnSolver::read(JsonObject object) {
  if (object.has("widths")) {
    const std::vector<int> widths = object.integers("widths", 3, 3, {1, 4096});
    std::copy(widths.begin(), widths.end(), widths_.begin());
  }
  training_ = TrainingSettings::from_json(object, {});
  object.finish();
}

nlohmann::json DcnnSolver::settings() const { return {{"widths", widths_}}; }

std::shared_ptr<Network> DcnnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<Dcnn>(sensor, widths_);
}

std::unique_ptr<Objective> DcnnSolver::make_objective(const FitInput&) const {
  return std::make_unique<SquaredError>();
}

}  // namespace ertbench
