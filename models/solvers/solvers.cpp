#include "models/solvers/solvers.h"

#include <algorithm>
#include <functional>

#include "core/errors.h"
#include "core/fields.h"
#include "forward/data/dataset_file.h"
#include "models/networks/dense_networks.h"
#include "models/networks/lean_net.h"
#include "models/solvers/learned_solver.h"
#include "models/training/standardisation.h"
#include "solvers/channel_mask.h"
#include "solvers/check/stored_solver.h"

namespace ertbench {
namespace {

std::unique_ptr<Objective> plain_objective(bool relative) {
  if (relative) return std::make_unique<RelativeError>();
  return std::make_unique<SquaredError>();
}

/// Written where it is not the default: files of older networks have none.
void visit_relative_loss(Fields& fields, bool& relative) {
  if (fields.writing() && !relative) return;
  fields.choice("loss", relative, {{"mse", false}, {"relative", true}});
}

}  // namespace

void FcnnSolver::visit(Fields& fields) {
  fields.integers("widths", widths_, 1, 16, {1, 65536});
  visit_relative_loss(fields, relative_loss_);
  visit_front(fields);
}

std::shared_ptr<Network> FcnnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<Fcnn>(sensor, widths_, told(sensor));
}

std::unique_ptr<Objective> FcnnSolver::make_objective(const FitInput&) const {
  return plain_objective(relative_loss_);
}

void DcnnSolver::check(const Sensor& sensor) const { Dcnn::check(sensor); }

void DcnnSolver::visit(Fields& fields) {
  fields.integers("widths", widths_, {1, 4096});
  visit_relative_loss(fields, relative_loss_);
}

std::shared_ptr<Network> DcnnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<Dcnn>(sensor, widths_);
}

std::unique_ptr<Objective> DcnnSolver::make_objective(const FitInput&) const {
  return plain_objective(relative_loss_);
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

void EitNnSolver::visit(Fields& fields) {
  std::vector<int> widths = dense_widths(sensor());
  fields.integers("dense_widths", widths, 1, 16, {1, 65536});
  if (fields.has("dense_widths")) dense_widths_ = std::move(widths);
  fields.integers("channels", channels_, {1, 4096});
  fields.choice("loss", loss_,
                {{"ssa-mse", Loss::blurred}, {"mse", Loss::mse}, {"relative", Loss::relative}});
  fields.number_or_auto("sensitivity_lambda", lambda_.value, Range::positive());
  if (fields.reading()) lambda_.place = fields.place("sensitivity_lambda");
}

std::shared_ptr<Network> EitNnSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<EitNn>(sensor, dense_widths(sensor), channels_);
}

std::unique_ptr<Objective> EitNnSolver::make_objective(const FitInput& input) const {
  if (loss_ != Loss::blurred) return plain_objective(loss_ == Loss::relative);
  return std::make_unique<SquaredError>(
      tensor_of(spatial_blur(input, lambda_.value).cast<float>()));
}

void DdErtSolver::check(const Sensor& sensor) const { DdErtGenerator::check(sensor); }

void DdErtSolver::visit(Fields& fields) {
  fields.integer("width", shape_.width, 1, 1024);
  fields.integer("convolutions", shape_.convolutions, 1, 16);
  fields.boolean("attention", shape_.attention);
  fields.choice("initialisation", start_,
                {{"physics", Start::physics}, {"lmmse", Start::lmmse}, {"random", Start::random}});
  fields.boolean("train_dense", train_dense_);
  AdversarialSettings& a = adversarial_;
  fields.choice(
      "content_loss", a.content,
      {{"l1", ContentLoss::l1}, {"mse", ContentLoss::mse}, {"relative", ContentLoss::relative}});
  fields.number("alpha", a.alpha, {0, 1e6});
  fields.number("beta", a.beta, {0, 1e6});
  fields.choice("adversarial_form", a.form,
                {{"minimax", AdversarialForm::minimax},
                 {"non-saturating", AdversarialForm::non_saturating},
                 {"least-squares", AdversarialForm::least_squares}});
  fields.number("mask_threshold", a.mask_threshold, {0, 1, true});
  fields.number("discriminator_rate", a.discriminator_rate, {0, 1000, true});
  fields.integers("discriminator_widths", a.discriminator_widths, {1, 4096});
  // Written where they are on: files of older networks have none of them.
  const bool all = !fields.writing();
  if (all || shape_.self_attention) {
    fields.choice("attention_form", shape_.self_attention, {{"spatial", false}, {"self", true}});
  }
  if (all || a.every > 1) fields.integer("adversarial_every", a.every, 1, 1000);
  if (all || a.spectral_norm) fields.boolean("spectral_norm", a.spectral_norm);
  if (all || a.instance_noise > 0) fields.number("instance_noise", a.instance_noise, {0, 10});
  if (all || a.label_smoothing > 0) fields.number("label_smoothing", a.label_smoothing, {0, 0.49});
  visit_front(fields);
}

namespace {

constexpr std::uint64_t most_scenes = 20000;  ///< that the linear estimate is fitted to
constexpr std::uint64_t estimated_at_a_time = 1024;

RowMajorMatrix double_matrix(const torch::Tensor& tensor) {
  const torch::Tensor wide = tensor.detach().to(torch::kFloat64).contiguous();
  return Eigen::Map<const RowMajorMatrix>(wide.data_ptr<double>(), wide.size(0), wide.size(1));
}

/// The linear estimate of y from standardised frames [frames, channels] as `enter` takes them in,
/// [frames, inputs], with `told` columns of zeros behind the channels.
LinearEstimate::Affine linear_estimate(
    const FitInput& input, const Standardisation& standardisation, Eigen::Index inputs, int told,
    const std::function<torch::Tensor(const torch::Tensor&)>& enter) {
  const DatasetFile& training = *input.training;
  const Eigen::RowVectorXd reference = training.reference_voltages().transpose();
  LinearEstimate estimate(inputs, input.sensor.pixels());
  const std::uint64_t scenes = std::min(training.size(), most_scenes);
  for (std::uint64_t first = 0; first < scenes; first += estimated_at_a_time) {
    const std::uint64_t count = std::min(estimated_at_a_time, scenes - first);
    const Frames changes = training.voltages(first, count).rowwise() - reference;
    const Images images =
        (1 - training.conductivity(first, count).array() / input.sensor.background) /
        standardisation.image;
    // The estimate is made before anything is told.
    const torch::Tensor frames = torch::constant_pad_nd(standardisation.apply(changes), {0, told});
    estimate.add(double_matrix(enter(frames)), images);
  }
  return estimate.solve();
}

}  // namespace

std::shared_ptr<Network> DdErtSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<DdErtGenerator>(sensor, shape_, told(sensor));
}

void DdErtSolver::initialise(Network& network, const FitInput& input,
                             Standardisation& standardisation) const {
  torch::nn::Linear& dense = dynamic_cast<DdErtGenerator&>(network).initial_imaging();
  if (start_ == Start::physics) set_sensitivity_inverse(dense, input, standardisation);
  if (start_ == Start::lmmse) {
    const LinearEstimate::Affine affine =
        linear_estimate(input, standardisation, dense->weight.size(1), told(input.sensor),
                        [](const torch::Tensor& frames) { return frames; });
    const torch::NoGradGuard no_gradients;
    dense->weight.copy_(tensor_of(affine.weights.cast<float>()));
    dense->bias.copy_(tensor_of(affine.offset.transpose().cast<float>()).flatten());
  }
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

/// Gives a network the weights of one that is told less; what only the network is told weighs
/// nothing. Throws InputError for a network of another shape.
void start_network(const NamedTensors& from, const NamedTensors& to) {
  const torch::NoGradGuard no_gradients;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const torch::Tensor& target = to[i].values;
    torch::Tensor source = i < from.size() ? from[i].values : torch::Tensor();
    if (source.defined() && to[i].name == "start.weight" && source.size(1) < target.size(1)) {
      source = torch::constant_pad_nd(source, {0, target.size(1) - source.size(1)});
    }
    if (!source.defined() || source.sizes() != target.sizes()) {
      throw InputError("\"start_from\": has another " + to[i].name +
                       "; name a network of the same width, blocks and maps");
    }
    to[i].values.copy_(source);
  }
}

}  // namespace

void LeanNetSolver::check(const Sensor& sensor) const { LeanNet::check(sensor); }

void LeanNetSolver::visit(Fields& fields) {
  fields.integer("width", shape_.width, 1, 1024);
  fields.integer("blocks", shape_.blocks, 0, 64);
  fields.integer("bottom_blocks", shape_.bottom_blocks, 0, 64);
  fields.integer("extra_maps", shape_.extra_maps, 0, 64);
  fields.choice("output", shape_.bounded, {{"bounded", true}, {"linear", false}});
  fields.choice("initialisation", lmmse_, {{"lmmse", true}, {"random", false}});
  fields.choice("loss", relative_loss_, {{"relative", true}, {"mse", false}});
  visit_front(fields);
  if (!fields.writing() || !start_from_.empty()) fields.text("start_from", start_from_);
}

std::shared_ptr<Network> LeanNetSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<LeanNet>(sensor, shape_, told(sensor));
}

void LeanNetSolver::initialise(Network& network, const FitInput& input,
                               Standardisation& standardisation) const {
  if (!start_from_.empty()) {
    LeanNetSolver start(JsonObject(nlohmann::json::object(), "lean-net", ""));
    start.load(fitted_file(start_from_, "."), input.sensor);
    standardisation = start.standardisation();
    start_network(weights_of(start.network()), weights_of(network));
    return;
  }
  if (!lmmse_) return;
  auto& net = dynamic_cast<LeanNet&>(network);
  const LinearEstimate::Affine affine = linear_estimate(
      input, standardisation, Reciprocity(input.sensor).pairs() + told(input.sensor),
      told(input.sensor), [&](const torch::Tensor& frames) { return net.means_of_pairs(frames); });
  net.set_first_image(tensor_of(affine.weights.cast<float>()),
                      tensor_of(affine.offset.transpose().cast<float>()).flatten());
}

std::unique_ptr<Objective> LeanNetSolver::make_objective(const FitInput&) const {
  return plain_objective(relative_loss_);
}

}  // namespace ertbench
