#include <algorithm>

#include "forward/data/dataset_file.h"
#include "models/networks/lean_net.h"
#include "models/solvers/solvers.h"
#include "models/training/linear_estimate.h"
#include "solvers/reciprocity.h"

namespace ertbench {
namespace {

constexpr std::uint64_t most_scenes = 20000;  ///< for the linear estimate
constexpr std::uint64_t scenes_at_a_time = 1024;

RowMajorMatrix double_matrix(const torch::Tensor& tensor) {
  const torch::Tensor wide = tensor.detach().to(torch::kFloat64).contiguous();
  return Eigen::Map<const RowMajorMatrix>(wide.data_ptr<double>(), wide.size(0), wide.size(1));
}

torch::Tensor float_tensor(const RowMajorMatrix& matrix) {
  return torch::from_blob(const_cast<double*>(matrix.data()), {matrix.rows(), matrix.cols()},
                          torch::kFloat64)
      .to(torch::kFloat32, false, true);
}

}  // namespace

void LeanNetSolver::check(const Sensor& sensor) const { LeanNet::check(sensor); }

void LeanNetSolver::read(JsonObject object) {
  shape_.width = object.integer_or("width", shape_.width, 1, 1024);
  shape_.blocks = object.integer_or("blocks", shape_.blocks, 0, 64);
  shape_.bottom_blocks = object.integer_or("bottom_blocks", shape_.bottom_blocks, 0, 64);
  shape_.extra_maps = object.integer_or("extra_maps", shape_.extra_maps, 0, 64);
  shape_.bounded = object.choice_or("output", shape_.bounded ? "bounded" : "linear",
                                    {"bounded", "linear"}) == "bounded";
  lmmse_ = object.choice_or("initialisation", lmmse_ ? "lmmse" : "random", {"lmmse", "random"}) ==
           "lmmse";
  relative_loss_ = object.choice_or("loss", relative_loss_ ? "relative" : "mse",
                                    {"relative", "mse"}) == "relative";
  training_ = TrainingSettings::from_json(
      object, {.epochs = 40, .batch = 32, .learning_rate = 4e-3, .slow_rate = 0.3});
  object.finish();
}

nlohmann::json LeanNetSolver::settings() const {
  return {{"width", shape_.width},
          {"blocks", shape_.blocks},
          {"bottom_blocks", shape_.bottom_blocks},
          {"extra_maps", shape_.extra_maps},
          {"output", shape_.bounded ? "bounded" : "linear"},
          {"initialisation", lmmse_ ? "lmmse" : "random"},
          {"loss", relative_loss_ ? "relative" : "mse"}};
}

std::shared_ptr<Network> LeanNetSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<LeanNet>(sensor, shape_);
}

void LeanNetSolver::initialise(Network& network, const FitInput& input,
                               const Standardisation& standardisation) const {
  if (!lmmse_) return;
  auto& net = dynamic_cast<LeanNet&>(network);
  const DatasetFile& training = *input.training;
  const Eigen::RowVectorXd reference = training.reference_voltages().transpose();
  LinearEstimate estimate(Reciprocity(input.sensor).pairs(), input.sensor.pixels());
  const std::uint64_t scenes = std::min(training.size(), most_scenes);
  for (std::uint64_t first = 0; first < scenes; first += scenes_at_a_time) {
    const std::uint64_t count = std::min(scenes_at_a_time, scenes - first);
    const Frames changes = training.voltages(first, count).rowwise() - reference;
    const Images images =
        (1 - training.conductivity(first, count).array() / input.sensor.background) /
        standardisation.image;
    estimate.add(double_matrix(net.means_of_pairs(standardisation.apply(changes))), images);
  }
  const LinearEstimate::Affine affine = estimate.solve();
  net.set_first_image(float_tensor(affine.weights),
                      float_tensor(affine.offset.transpose()).flatten());
}

std::unique_ptr<Objective> LeanNetSolver::make_objective(const FitInput&) const {
  if (relative_loss_) return std::make_unique<RelativeError>();
  return std::make_unique<SquaredError>();
}

}  // namespace ertbench
