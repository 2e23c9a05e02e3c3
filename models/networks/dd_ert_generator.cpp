#include "models/networks/dd_ert_generator.h"

#include <torch/nn/functional/conv.h>
#include <torch/nn/init.h>
#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/types.h>

#include <algorithm>

#include "core/errors.h"
#include "models/networks/plan_layers.h"

namespace ertbench {

SpatialAttentionImpl::SpatialAttentionImpl()
    : convolution_(torch::nn::Conv2dOptions(2, 1, 7).padding(3).bias(false)) {
  register_module("convolution", convolution_);
}

torch::Tensor SpatialAttentionImpl::forward(const torch::Tensor& features) {
  const torch::Tensor summary = torch::cat({features.mean(1, true), features.amax({1}, true)}, 1);
  return features * convolution_->forward(summary).sigmoid();
}

int SpatialAttentionImpl::add_to(PlanBuilder& plan, int maps) const {
  const ConvolutionWeights weights = weights_of(*convolution_, nullptr);
  return plan.attention(maps, weights.kernel, weights.weights);
}

SelfAttentionImpl::SelfAttentionImpl(int channels)
    : query_(torch::nn::Conv2dOptions(channels, std::max(channels / 8, 1), 1)),
      key_(torch::nn::Conv2dOptions(channels, std::max(channels / 8, 1), 1)),
      value_(torch::nn::Conv2dOptions(channels, channels, 1)),
      gain_(register_parameter("gain", torch::zeros({1}))) {
  register_module("query", query_);
  register_module("key", key_);
  register_module("value", value_);
}

torch::Tensor SelfAttentionImpl::forward(const torch::Tensor& features) {
  const torch::Tensor queries = query_->forward(features).flatten(2);
  const torch::Tensor keys = key_->forward(features).flatten(2);
  const torch::Tensor shares = queries.transpose(1, 2).matmul(keys).softmax(-1);
  const torch::Tensor values = value_->forward(features).flatten(2).matmul(shares.transpose(1, 2));
  return features + gain_ * values.view_as(features);
}

namespace {

/// Iterations before the first training step. The singular value converges long before its vector;
/// the steps of the training continue both.
constexpr int first_iterations = 15;
constexpr double least_norm = 1e-12;  ///< of a kernel of zeros, which stays what it is

torch::Tensor normalised(const torch::Tensor& vector) {
  return vector / vector.norm().clamp_min(least_norm);
}

// Element-wise products and sums, because matrix products would be rounded to bfloat16 in a
// training of that precision.

torch::Tensor right_of(const torch::Tensor& matrix, const torch::Tensor& left) {
  return normalised((matrix * left).sum(0, true));
}

torch::Tensor left_of(const torch::Tensor& matrix, const torch::Tensor& right) {
  return normalised((matrix * right).sum(1, true));
}

}  // namespace

SpectralConvolutionImpl::SpectralConvolutionImpl(int inputs, int outputs, int size, int stride,
                                                 int padding)
    : convolution_(torch::nn::Conv2dOptions(inputs, outputs, size)),
      left_(normalised(torch::ones({outputs, 1}))),
      stride_(stride),
      padding_(padding) {
  register_module("convolution", convolution_);
  register_buffer("left", left_);
  for (int i = 0; i < first_iterations; ++i) kernel();
}

torch::Tensor SpectralConvolutionImpl::kernel() {
  const torch::Tensor matrix = convolution_->weight.flatten(1);
  torch::Tensor left;
  torch::Tensor right;
  {
    const torch::NoGradGuard no_gradients;
    right = right_of(matrix, left_);
    left = left_of(matrix, right);
    if (is_training()) left_.copy_(left);
  }
  // The vectors are held fixed, so that the gradient is that of the singular value itself.
  const torch::Tensor largest = (matrix * left * right).sum();
  return convolution_->weight / largest.clamp_min(least_norm);
}

torch::Tensor SpectralConvolutionImpl::forward(const torch::Tensor& maps) {
  return torch::nn::functional::conv2d(maps, kernel(),
                                       torch::nn::functional::Conv2dFuncOptions()
                                           .bias(convolution_->bias)
                                           .stride(stride_)
                                           .padding(padding_));
}

namespace nn = torch::nn;
namespace {

/// Initial bias before the sigmoid, for an almost empty image. From the middle of its range the
/// background pixels would drive it into saturation for good.
constexpr double first_logit = -4;

/// `first` is the block's first convolution; the others keep the size.
nn::Sequential block(const nn::Conv2dOptions& first, int convolutions) {
  nn::Sequential layers;
  const auto width = first.out_channels();
  for (int i = 0; i < convolutions; ++i) {
    nn::Conv2dOptions options = i == 0 ? first : nn::Conv2dOptions(width, width, 3).padding(1);
    layers->push_back(nn::Conv2d(options.bias(false)));
    layers->push_back(nn::BatchNorm2d(width));
    layers->push_back(nn::ReLU(nn::ReLUOptions(true)));
  }
  return layers;
}

nn::Conv2dOptions same(int inputs, int width) {
  return nn::Conv2dOptions(inputs, width, 3).padding(1);
}

nn::Conv2dOptions halving(int inputs, int width) { return same(inputs, width).stride(2); }

nn::ConvTranspose2dOptions doubling(int inputs, int width) {
  return nn::ConvTranspose2dOptions(inputs, width, 2).stride(2);
}

}  // namespace

void DdErtGenerator::check(const Sensor& sensor) {
  const auto suits = [](int side) { return side % 4 == 0 && side >= 12; };
  if (!suits(sensor.image_columns()) || !suits(sensor.image_rows())) {
    throw InputError("dd-ert needs an image grid of 12, 16, 20, 24, ... pixels, the sensor has " +
                     std::to_string(sensor.image_columns()) +
                     (sensor.image_rows() == sensor.image_columns()
                          ? ""
                          : " x " + std::to_string(sensor.image_rows())));
  }
}

DdErtGenerator::DdErtGenerator(const Sensor& sensor, const GeneratorShape& shape, int told)
    : rows_(sensor.image_rows()),
      columns_(sensor.image_columns()),
      initial_imaging_(sensor.channels() + told, sensor.pixels()),
      encode_full_(block(same(1, shape.width), shape.convolutions)),
      encode_half_(block(halving(shape.width, 2 * shape.width), shape.convolutions)),
      encode_quarter_(block(halving(2 * shape.width, 4 * shape.width), shape.convolutions)),
      bottom_(block(nn::Conv2dOptions(4 * shape.width, 8 * shape.width, 3), shape.convolutions)),
      rise_quarter_(nn::ConvTranspose2dOptions(8 * shape.width, 4 * shape.width, 3)),
      rise_half_(doubling(4 * shape.width, 2 * shape.width)),
      rise_full_(doubling(2 * shape.width, shape.width)),
      decode_quarter_(block(same(8 * shape.width, 4 * shape.width), shape.convolutions)),
      decode_half_(block(same(4 * shape.width, 2 * shape.width), shape.convolutions)),
      decode_full_(block(same(2 * shape.width, shape.width), shape.convolutions)),
      image_(nn::Conv2dOptions(shape.width, 1, 1)) {
  register_module("initial_imaging", initial_imaging_);
  register_module("encode_full", encode_full_);
  register_module("encode_half", encode_half_);
  register_module("encode_quarter", encode_quarter_);
  register_module("bottom", bottom_);
  register_module("rise_quarter", rise_quarter_);
  register_module("rise_half", rise_half_);
  register_module("rise_full", rise_full_);
  register_module("decode_quarter", decode_quarter_);
  register_module("decode_half", decode_half_);
  register_module("decode_full", decode_full_);
  register_module("image", image_);
  if (shape.attention && shape.self_attention) {
    self_quarter_ = register_module("self_quarter", SelfAttention(4 * shape.width));
    self_bottom_ = register_module("self_bottom", SelfAttention(8 * shape.width));
  } else if (shape.attention) {
    attention_quarter_ = register_module("attention_quarter", SpatialAttention());
    attention_bottom_ = register_module("attention_bottom", SpatialAttention());
  }
  nn::init::constant_(image_->bias, first_logit);
}

torch::Tensor DdErtGenerator::forward(const torch::Tensor& frames) {
  const auto attend = [](SpatialAttention& spatial, SelfAttention& self, const torch::Tensor& x) {
    if (!self.is_empty()) return self->forward(x);
    return spatial.is_empty() ? x : spatial->forward(x);
  };
  const torch::Tensor initial = initial_imaging_->forward(frames).view({-1, 1, rows_, columns_});
  const torch::Tensor full = encode_full_->forward(initial);
  const torch::Tensor half = encode_half_->forward(full);
  const torch::Tensor quarter =
      attend(attention_quarter_, self_quarter_, encode_quarter_->forward(half));
  const torch::Tensor bottom = attend(attention_bottom_, self_bottom_, bottom_->forward(quarter));
  const torch::Tensor up_quarter =
      decode_quarter_->forward(torch::cat({rise_quarter_->forward(bottom), quarter}, 1));
  const torch::Tensor up_half =
      decode_half_->forward(torch::cat({rise_half_->forward(up_quarter), half}, 1));
  const torch::Tensor up_full =
      decode_full_->forward(torch::cat({rise_full_->forward(up_half), full}, 1));
  return image_->forward(up_full).to(torch::kFloat32).sigmoid();
}

std::unique_ptr<InferencePlan> DdErtGenerator::plan(PlanBuilder plan) const {
  if (!self_bottom_.is_empty()) return nullptr;
  const auto attend = [&](const SpatialAttention& attention, int maps) {
    return attention.is_empty() ? maps : attention->add_to(plan, maps);
  };
  const auto rise = [&](const nn::ConvTranspose2d& layer, int maps) {
    return plan.transposed_convolution(maps, weights_of(*layer, nullptr), {});
  };
  const int frame = plan.input(static_cast<int>(initial_imaging_->weight.size(1)));
  const int initial =
      plan.maps(plan.dense(frame, weights_of(*initial_imaging_, nullptr), {}), 1, rows_, columns_);
  const int full = add_layers(plan, encode_full_, {initial});
  const int half = add_layers(plan, encode_half_, {full});
  const int quarter = attend(attention_quarter_, add_layers(plan, encode_quarter_, {half}));
  const int bottom = attend(attention_bottom_, add_layers(plan, bottom_, {quarter}));
  const int up_quarter = add_layers(plan, decode_quarter_, {rise(rise_quarter_, bottom), quarter});
  const int up_half = add_layers(plan, decode_half_, {rise(rise_half_, up_quarter), half});
  const int up_full = add_layers(plan, decode_full_, {rise(rise_full_, up_half), full});
  const int logits = plan.image_convolution(up_full, weights_of(*image_, nullptr));
  return plan.finish(plan.sigmoid(logits));
}

PatchDiscriminatorImpl::PatchDiscriminatorImpl(const std::array<int, 2>& widths,
                                               bool spectral_norm) {
  const auto leaky = [] { return nn::LeakyReLU(nn::LeakyReLUOptions().negative_slope(0.2)); };
  if (spectral_norm) {
    layers_->push_back(SpectralConvolution(1, widths[0], 4, 2, 1));
    layers_->push_back(leaky());
    layers_->push_back(SpectralConvolution(widths[0], widths[1], 4, 1, 1));
    layers_->push_back(leaky());
    layers_->push_back(SpectralConvolution(widths[1], 1, 4, 1, 1));
  } else {
    layers_->push_back(nn::Conv2d(nn::Conv2dOptions(1, widths[0], 4).stride(2).padding(1)));
    layers_->push_back(leaky());
    layers_->push_back(
        nn::Conv2d(nn::Conv2dOptions(widths[0], widths[1], 4).padding(1).bias(false)));
    layers_->push_back(nn::BatchNorm2d(widths[1]));
    layers_->push_back(leaky());
    layers_->push_back(nn::Conv2d(nn::Conv2dOptions(widths[1], 1, 4).padding(1)));
  }
  register_module("layers", layers_);
}

torch::Tensor PatchDiscriminatorImpl::forward(const torch::Tensor& images) {
  return layers_->forward(images);
}

}  // namespace ertbench
