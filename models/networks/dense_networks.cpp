#include "models/networks/dense_networks.h"

#include <torch/csrc/jit/ir/ir.h>
#include <torch/nn/functional/padding.h>
#include <torch/nn/init.h>
#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/pooling.h>
#include <torch/types.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "core/errors.h"
#include "models/networks/network.h"
#include "models/networks/plan_layers.h"

namespace ertbench {
namespace {

namespace jit = torch::jit;
namespace aten = c10::aten;

/// Constant tensor of a graph; no value for computed tensors or other values.
std::optional<torch::Tensor> constant_tensor(jit::Value* value) {
  const auto constant = jit::toIValue(value);
  if (!constant || !constant->isTensor()) return std::nullopt;
  return constant->toTensor();
}

/// Scale and shift per channel of a normalisation with fixed statistics.
struct Affine {
  torch::Tensor scale;
  torch::Tensor shift;
};

/// aten::batch_norm(input, weight, bias, mean, variance, training, momentum, eps, ...).
std::optional<Affine> affine_of(jit::Node* normalisation) {
  std::vector<torch::Tensor> tensors;
  for (const std::size_t input : {1, 2, 3, 4}) {
    const auto tensor = constant_tensor(normalisation->input(input));
    if (!tensor) return std::nullopt;
    tensors.push_back(*tensor);
  }
  const auto training = jit::toIValue(normalisation->input(5));
  const auto eps = jit::toIValue(normalisation->input(7));
  if (!training || training->toBool() || !eps) return std::nullopt;
  const torch::Tensor scale = tensors[0] * torch::rsqrt(tensors[3] + eps->toDouble());
  return Affine{scale, tensors[1] - tensors[2] * scale};
}

/// A dense layer as it is traced, with constant weights: aten::matmul(input, weights) or
/// aten::addmm(bias, input, weights, 1, 1).
struct DenseLayer {
  jit::Node* node;
  jit::Value* input;
  torch::Tensor weights;  ///< [inputs, outputs]
  torch::Tensor bias;     ///< [outputs]
};

std::optional<DenseLayer> dense_layer(jit::Node* node) {
  const bool biased = node->kind() == aten::addmm;
  if (!biased && node->kind() != aten::matmul) return std::nullopt;
  const auto weights = constant_tensor(node->input(biased ? 2 : 1));
  if (!weights || weights->dim() != 2) return std::nullopt;
  if (!biased) {
    return DenseLayer{node, node->input(0), *weights,
                      torch::zeros({weights->size(1)}, weights->options())};
  }
  const auto bias = constant_tensor(node->input(0));
  if (!bias) return std::nullopt;
  return DenseLayer{node, node->input(1), *weights, *bias};
}

std::vector<DenseLayer> dense_layers(jit::Graph& graph) {
  std::vector<DenseLayer> out;
  for (jit::Node* node : graph.nodes()) {
    if (const auto layer = dense_layer(node)) out.push_back(*layer);
  }
  return out;
}

}  // namespace

void fold_normalisation_into_dense_layers(jit::Graph& graph) {
  const torch::NoGradGuard no_gradients;
  for (const DenseLayer& layer : dense_layers(graph)) {
    const auto& uses = layer.node->output()->uses();
    if (uses.size() != 1 || uses[0].user->kind() != aten::batch_norm) continue;
    jit::Node* normalisation = uses[0].user;
    const auto affine = affine_of(normalisation);
    if (!affine) continue;
    const jit::WithInsertPoint before(layer.node);
    jit::Value* weights = graph.insertConstant(layer.weights * affine->scale);
    jit::Value* bias = graph.insertConstant(layer.bias * affine->scale + affine->shift);
    normalisation->output()->replaceAllUsesWith(
        graph.insert(aten::addmm, {bias, layer.input, weights}));
    normalisation->destroy();
    layer.node->destroy();
  }
}

void make_dense_layers_matrix_vector(jit::Graph& graph) {
  for (const DenseLayer& layer : dense_layers(graph)) {
    if (layer.weights.scalar_type() != torch::kFloat32) continue;
    const jit::WithInsertPoint before(layer.node);
    jit::Value* bias = graph.insertConstant(layer.bias);
    jit::Value* matrix = graph.insertConstant(layer.weights.t().contiguous());
    jit::Value* vector = graph.insert(aten::squeeze, {layer.input, 0});
    jit::Value* product = graph.insert(aten::addmv, {bias, matrix, vector});
    layer.node->output()->replaceAllUsesWith(graph.insert(aten::unsqueeze, {product, 0}));
    layer.node->destroy();
  }
}

namespace nn = torch::nn;

int append_dense_layers(nn::Sequential& layers, int inputs, const std::vector<int>& widths) {
  for (const int width : widths) {
    layers->push_back(nn::Linear(nn::LinearOptions(inputs, width).bias(false)));
    layers->push_back(nn::BatchNorm1d(width));
    layers->push_back(nn::ReLU(nn::ReLUOptions(true)));
    inputs = width;
  }
  return inputs;
}

Fcnn::Fcnn(const Sensor& sensor, const std::vector<int>& widths, int told)
    : inputs_(sensor.channels() + told),
      rows_(sensor.image_rows()),
      columns_(sensor.image_columns()) {
  const int last = append_dense_layers(layers_, inputs_, widths);
  layers_->push_back(nn::Linear(last, sensor.pixels()));
  register_module("layers", layers_);
}

torch::Tensor Fcnn::forward(const torch::Tensor& frames) {
  return layers_->forward(frames).view({-1, 1, rows_, columns_});
}

std::unique_ptr<InferencePlan> Fcnn::plan(PlanBuilder plan) const {
  const int image = add_layers(plan, layers_, {plan.input(inputs_)});
  return plan.finish(plan.maps(image, 1, rows_, columns_));
}

namespace {

void append_activation(nn::Sequential& layers, int width) {
  layers->push_back(nn::BatchNorm2d(width));
  layers->push_back(PRelu(width));
}

void append_convolution(nn::Sequential& layers, int inputs, int width) {
  layers->push_back(nn::Conv2d(nn::Conv2dOptions(inputs, width, 3).padding(1).bias(false)));
  append_activation(layers, width);
}

void append_enlargement(nn::Sequential& layers, int inputs, int width, int factor) {
  layers->push_back(nn::ConvTranspose2d(
      nn::ConvTranspose2dOptions(inputs, width, factor).stride(factor).bias(false)));
  append_activation(layers, width);
}

}  // namespace

void Dcnn::check(const Sensor& sensor) {
  const auto suits = [](int pairs, int pixels) {
    return pairs % 4 == 0 && 2 * pixels == 3 * pairs;
  };
  if (suits(sensor.drives(), sensor.image_rows()) &&
      suits(sensor.measurements(), sensor.image_columns())) {
    return;
  }
  if (sensor.is_adjacent() && sensor.image_rows() == sensor.image_columns()) {
    throw InputError(
        "dcnn needs a multiple of 4 electrodes and an image grid of 3/2 as many pixels (16 and "
        "24), the sensor has " +
        std::to_string(sensor.electrode_count) + " and " + std::to_string(sensor.image_grid));
  }
  throw InputError(
      "dcnn needs multiples of 4 drives and measurements and an image of 3/2 as many "
      "rows and columns (16 x 16 and 24 x 24), the sensor has " +
      std::to_string(sensor.drives()) + " x " + std::to_string(sensor.measurements()) + " and " +
      std::to_string(sensor.image_rows()) + " x " + std::to_string(sensor.image_columns()));
}

Dcnn::Dcnn(const Sensor& sensor, const std::array<int, 3>& widths)
    : channels_(sensor.channels()), drives_(sensor.drives()), measurements_(sensor.measurements()) {
  const auto [w0, w1, w2] = widths;
  append_convolution(layers_, 1, w0);
  layers_->push_back(nn::MaxPool2d(2));
  append_convolution(layers_, w0, w1);
  layers_->push_back(nn::MaxPool2d(2));
  append_convolution(layers_, w1, w2);
  append_enlargement(layers_, w2, w1, 3);
  append_enlargement(layers_, w1, w0, 2);
  layers_->push_back(nn::Conv2d(nn::Conv2dOptions(w0, 1, 3).padding(1)));
  register_module("layers", layers_);

  std::vector<std::int64_t> source(static_cast<std::size_t>(drives_ * measurements_),
                                   sensor.channels());
  std::int64_t index = 0;
  for (const Channel& channel : channels_of(sensor)) {
    source[static_cast<std::size_t>(channel.drive * measurements_ + channel.measurement)] = index++;
  }
  source_ = torch::tensor(source);
}

torch::Tensor Dcnn::forward(const torch::Tensor& frames) {
  source_ = source_.to(frames.device());
  const torch::Tensor with_none =
      nn::functional::pad(frames, nn::functional::PadFuncOptions({0, 1}));
  return layers_->forward(with_none.index_select(1, source_).view({-1, 1, drives_, measurements_}));
}

std::unique_ptr<InferencePlan> Dcnn::plan(PlanBuilder plan) const {
  std::vector<int> sources = integers_of(source_);
  std::replace(sources.begin(), sources.end(), channels_, PlanBuilder::none);
  const int map = plan.maps(plan.gather(plan.input(channels_), sources), 1, drives_, measurements_);
  return plan.finish(add_layers(plan, layers_, {map}, true));
}

namespace {
constexpr double first_weight = 1e-3;
}  // namespace

EitNn::EitNn(const Sensor& sensor, const std::vector<int>& dense_widths,
             const std::array<int, 2>& channels)
    : inputs_(sensor.channels()), rows_(sensor.image_rows()), columns_(sensor.image_columns()) {
  append_dense_layers(dense_, sensor.channels(), dense_widths);
  int inputs = 1;
  for (const int width : channels) {
    convolutions_->push_back(
        nn::Conv2d(nn::Conv2dOptions(inputs, width, 3).padding(1).bias(false)));
    convolutions_->push_back(nn::BatchNorm2d(width));
    convolutions_->push_back(nn::ReLU(nn::ReLUOptions(true)));
    inputs = width;
  }
  nn::ConvTranspose2d image(nn::ConvTranspose2dOptions(inputs, 1, 3).padding(1).bias(false));
  // Targets are nearly empty; unlearning a random first image would take most of the training.
  nn::init::uniform_(image->weight, -first_weight, first_weight);
  convolutions_->push_back(image);
  register_module("dense", dense_);
  register_module("convolutions", convolutions_);
}

torch::Tensor EitNn::forward(const torch::Tensor& frames) {
  return convolutions_->forward(dense_->forward(frames).view({-1, 1, rows_, columns_}));
}

std::unique_ptr<InferencePlan> EitNn::plan(PlanBuilder plan) const {
  const int dense = add_layers(plan, dense_, {plan.input(inputs_)});
  return plan.finish(add_layers(plan, convolutions_, {plan.maps(dense, 1, rows_, columns_)}, true));
}

}  // namespace ertbench
