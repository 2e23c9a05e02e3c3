#include "models/solvers/solvers.h"

#include <algorithm>

#include "core/errors.h"
#include "forward/data/dataset_file.h"
#include "models/networks/dense_networks.h"
#include "models/networks/lean_net.h"
#include "models/solvers/learned_solver.h"
#include "models/training/standardisation.h"
#include "solvers/channel_mask.h"

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

std::vector<int> EitNnSolver::dense_widths(const Sensor& sensor) const {
  return dense_widths_.value_or(std::vector{2304, 576, sensor.pixels()});
}

void EitNnSolver::check(const Sensor& sensor) const {
  const int last = dense_widths(sensor).back();
  if (last != sensor.pixels()) {
    throw InputError(
        "eit-nn makes an image of its last dense layer: \"dense_widths\" must end in " +
        std::to_string(sensor.pixels()) + ", the sensor's pixels, not in " + std::to_string(last));
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
  nlohmann::json out = {{"dense_widths", dense_widths(sensor())},
                        {"channels", channels_},
                        {"loss", blurred_target_ ? "ssa-mse" : "mse"},
                        {"sensitivity_lambda", "auto"}};
  if (lambda_.value) out["sensitivity_lambda"] = *lambda_.value;
  return out;
}

std::shared_ptr<Network> EitNnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<EitNn>(sensor, dense_widths(sensor), channels_);
}

std::unique_ptr<Objective> EitNnSolver::make_objective(const FitInput& input) const {
  if (!blurred_target_) return std::make_unique<SquaredError>();
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> blur =
      spatial_blur(input, lambda_.value).cast<float>();
  return std::make_unique<SquaredError>(
      torch::from_blob(const_cast<float*>(blur.data()), {blur.rows(), blur.cols()}).clone());
}

void DdErtSolver::check(const Sensor& sensor) const { DdErtGenerator::check(sensor); }

void DdErtSolver::read(JsonObject object) {
  shape_.width = object.integer_or("width", shape_.width, 1, 1024);
  shape_.convolutions = object.integer_or("convolutions", shape_.convolutions, 1, 16);
  shape_.attention = object.boolean_or("attention", shape_.attention);
  physics_ = object.choice_or("initialisation", physics_ ? "physics" : "random",
                              {"physics", "random"}) == "physics";
  train_dense_ = object.boolean_or("train_dense", train_dense_);
  AdversarialSettings& a = adversarial_;
  a.squared_content =
      object.choice_or("content_loss", a.squared_content ? "mse" : "l1", {"l1", "mse"}) == "mse";
  a.alpha = object.number_or("alpha", a.alpha, {0, 1e6});
  a.beta = object.number_or("beta", a.beta, {0, 1e6});
  a.form = adversarial_form_from_name(object.choice_or(
      "adversarial_form", name_of(a.form), {"minimax", "non-saturating", "least-squares"}));
  a.mask_threshold = object.number_or("mask_threshold", a.mask_threshold, {0, 1, true});
  a.discriminator_rate =
      object.number_or("discriminator_rate", a.discriminator_rate, {0, 1000, true});
  a.spectral_norm = object.boolean_or("spectral_norm", a.spectral_norm);
  a.instance_noise = object.number_or("instance_noise", a.instance_noise, {0, 10});
  a.label_smoothing = object.number_or("label_smoothing", a.label_smoothing, {0, 0.49});
  if (object.has("discriminator_widths")) {
    const std::vector<int> widths = object.integers("discriminator_widths", 2, 2, {1, 4096});
    std::copy(widths.begin(), widths.end(), a.discriminator_widths.begin());
  }
  training_ = TrainingSettings::from_json(
      object, {.batch = 16, .learning_rate = 4e-3, .freeze_statistics = 0.4});
  object.finish();
}

nlohmann::json DdErtSolver::settings() const {
  const AdversarialSettings& a = adversarial_;
  nlohmann::json out = {{"width", shape_.width},
                        {"convolutions", shape_.convolutions},
                        {"attention", shape_.attention},
                        {"initialisation", physics_ ? "physics" : "random"},
                        {"train_dense", train_dense_},
                        {"content_loss", a.squared_content ? "mse" : "l1"},
                        {"alpha", a.alpha},
                        {"beta", a.beta},
                        {"adversarial_form", name_of(a.form)},
                        {"mask_threshold", a.mask_threshold},
                        {"discriminator_rate", a.discriminator_rate},
                        {"discriminator_widths", a.discriminator_widths}};
  // Left out if they are off, as in files of networks from before these settings existed.
  if (a.spectral_norm) out["spectral_norm"] = true;
  if (a.instance_noise > 0) out["instance_noise"] = a.instance_noise;
  if (a.label_smoothing > 0) out["label_smoothing"] = a.label_smoothing;
  return out;
}

std::shared_ptr<Network> DdErtSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<DdErtGenerator>(sensor, shape_);
}

void DdErtSolver::initialise(Network& network, const FitInput& input,
                             const Standardisation& standardisation) const {
  torch::nn::Linear& dense = dynamic_cast<DdErtGenerator&>(network).initial_imaging();
  if (physics_) set_sensitivity_inverse(dense, input, standardisation);
  if (!train_dense_) {
    dense->weight.set_requires_grad(false);
    dense->bias.set_requires_grad(false);
  }
}

std::unique_ptr<Objective> DdErtSolver::make_objective(const FitInput&) const {
  AdversarialSettings settings = adversarial_;
  settings.bfloat16 = training_.bfloat16;
  settings.seed = training_.seed;
  return std::make_unique<AdversarialObjective>(settings);
}

namespace {

constexpr std::uint64_t most_scenes = 20000;  ///< that the linear estimate is fitted to
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
