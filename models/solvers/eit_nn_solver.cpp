#include "core/errors.h"
#include "models/networks/eit_nn.h"
#include "models/solvers/sensitivity.h"
#include "models/solvers/solvers.h"

namespace ertbench {

namespace {

/// Those of the default end in the pixels of the sensor, whatever it is.
std::vector<int> widths_for(const Sensor& sensor, std::vector<int> widths) {
  if (widths == std::vector{2304, 576, 576}) widths.back() = sensor.pixels();
  return widths;
}

}  // namespace

void EitNnSolver::check(const Sensor& sensor) const {
  if (widths_for(sensor, dense_widths_).back() != sensor.pixels()) {
    throw InputError(
        "eit-nn makes an image of its last dense layer: \"dense_widths\" must end in " +
        std::to_string(sensor.pixels()) + ", the sensor's pixels, not in " +
        std::to_string(dense_widths_.back()));
  }
}

void EitNnSolver::read(JsonObject object) {
  if (object.has("dense_widths"))
    dense_widths_ = object.integers("dense_widths", 1, 16, {1, 65536});
  if (object.has("channels")) {
    const std::vector<int> channels = object.integers("channels", 2, 2, {1, 4096});
    std::copy(channels.begin(), channels.end(), channels_.begin());
  }
  blurred_target_ = object.choice_or("loss", blurred_target_ ? "ssa-mse" : "mse",
                                     {"ssa-mse", "mse"}) == "ssa-mse";
  lambda_ = read_tunable(object, "sensitivity_lambda", Range::positive());
  training_ = TrainingSettings::from_json(object, {});
  object.finish();
}

nlohmann::json EitNnSolver::settings() const {
  nlohmann::json out = {{"dense_widths", dense_widths_},
                        {"channels", channels_},
                        {"loss", blurred_target_ ? "ssa-mse" : "mse"},
                        {"sensitivity_lambda", "auto"}};
  if (lambda_.value) out["sensitivity_lambda"] = *lambda_.value;
  return out;
}

std::shared_ptr<Network> EitNnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<EitNn>(sensor, widths_for(sensor, dense_widths_), channels_);
}

std::unique_ptr<Objective> EitNnSolver::make_objective(const FitInput& input) const {
  if (!blurred_target_) return std::make_unique<SquaredError>();
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> blur =
      spatial_blur(input, lambda_.value).cast<float>();
  return std::make_unique<SquaredError>(
      torch::from_blob(const_cast<float*>(blur.data()), {blur.rows(), blur.cols()}).clone());
}

}  // namespace ertbench
