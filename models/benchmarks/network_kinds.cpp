#include "models/benchmarks/network_kinds.h"

#include "models/networks/dcnn.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/eit_nn.h"
#include "models/networks/fcnn.h"
#include "models/networks/lean_net.h"
#include "models/solvers/solvers.h"
#include "models/training/adversarial_objective.h"
#include "solvers/check/checked_solver.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::unique_ptr<Objective> squared_error(bool) { return std::make_unique<SquaredError>(); }

std::unique_ptr<Objective> adversarial(bool bfloat16) {
  return std::make_unique<AdversarialObjective>(AdversarialSettings{.bfloat16 = bfloat16});
}

template <typename Learned>
std::unique_ptr<Solver> solver(json training) {
  const SolverInfo info = {"", {}, make_from_json<Learned>};
  return CheckedSolver::make(Learned::type, info, JsonObject(training, "benchmark", ""));
}

std::shared_ptr<Network> lean_net() { return std::make_shared<LeanNet>(Sensor{}, LeanShape{}); }

template <int convolutions>
std::shared_ptr<Network> dd_ert() {
  return std::make_shared<DdErtGenerator>(Sensor{}, GeneratorShape{.convolutions = convolutions});
}

template <int convolutions>
std::unique_ptr<Solver> dd_ert_solver(json training) {
  training["convolutions"] = convolutions;
  training["initialisation"] = "random";
  return solver<DdErtSolver>(training);
}

}  // namespace

std::span<const NetworkKind> network_kinds() {
  static const NetworkKind kinds[] = {
      {"fcnn",
       []() -> std::shared_ptr<Network> {
         return std::make_shared<Fcnn>(Sensor{}, std::vector{2304, 576, 576});
       },
       squared_error, solver<FcnnSolver>},
      {"dcnn",
       []() -> std::shared_ptr<Network> {
         return std::make_shared<Dcnn>(Sensor{}, std::array{64, 128, 256});
       },
       squared_error, solver<DcnnSolver>},
      {"eit-nn",
       []() -> std::shared_ptr<Network> {
         return std::make_shared<EitNn>(Sensor{}, std::vector{2304, 576, 576}, std::array{32, 64});
       },
       squared_error,
       [](json training) {
         training["loss"] = "mse";  // without a choice of the blur
         return solver<EitNnSolver>(training);
       }},
      {"dd-ert", dd_ert<2>, adversarial, dd_ert_solver<2>},
      {"dd-ert/convolutions:1", dd_ert<1>, adversarial, dd_ert_solver<1>},
      {"lean-net", lean_net,
       [](bool) -> std::unique_ptr<Objective> { return std::make_unique<RelativeError>(); },
       solver<LeanNetSolver>},
  };
  return kinds;
}

}  // namespace ertbench
