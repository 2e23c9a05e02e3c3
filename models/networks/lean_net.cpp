#include "models/networks/lean_net.h"

#include <torch/nn/functional/pixelshuffle.h>
#include <torch/nn/init.h>
#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/types.h>

#include "core/errors.h"
#include "models/networks/plan_layers.h"

namespace ertbench {
namespace nn = torch::nn;
namespace {

constexpr int sub_pixels = 4;  ///< of the image in a pixel at half the resolution
/// Initial scale of the dense layer's further maps: order 1 for standardised inputs.
constexpr double first_map_weight = 0.1;
constexpr double first_correction = 1e-3;
constexpr double untouched_logit = -4;  ///< an almost untouched sheet, as in DdErtGenerator

void append_normalised(nn::Sequential& layers, const nn::Conv2dOptions& convolution) {
  nn::Conv2dOptions options = convolution;
  layers->push_back(nn::Conv2d(options.padding(1).bias(false)));
  layers->push_back(nn::BatchNorm2d(convolution.out_channels()));
}

/// The convolutions of `count` blocks; LeanNet::blocks adds what goes around them.
void append_blocks(nn::Sequential& layers, int count, int width) {
  for (int i = 0; i < count; ++i) append_normalised(layers, {width, width, 3});
}

torch::Tensor pairs_of(const Sensor& sensor, int told) {
  std::vector<std::int64_t> channels;
  for (const auto& [a, b] : reciprocal_pairs(sensor)) channels.insert(channels.end(), {a, b});
  // Each is a pair of its own.
  for (int i = 0; i < told; ++i) channels.insert(channels.end(), 2, sensor.channels() + i);
  return torch::tensor(channels).view({-1, 2});
}

}  // namespace

void LeanNet::check(const Sensor& sensor) {
  if (sensor.image_columns() % 4 != 0 || sensor.image_rows() % 4 != 0) {
    throw InputError("lean-net needs an image grid of a multiple of 4 pixels, the sensor has " +
                     std::to_string(sensor.image_columns()) +
                     (sensor.image_rows() == sensor.image_columns()
                          ? ""
                          : " x " + std::to_string(sensor.image_rows())));
  }
}

LeanNet::LeanNet(const Sensor& sensor, const LeanShape& shape, int told)
    : inputs_(sensor.channels() + told),
      rows_(sensor.image_rows() / 2),
      columns_(sensor.image_columns() / 2),
      pairs_(pairs_of(sensor, told)),
      start_(pairs_.size(0), (sub_pixels + shape.extra_maps) * rows_ * columns_),
      rise_(nn::ConvTranspose2dOptions(2 * shape.width, shape.width, 2).stride(2)),
      image_(nn::Conv2dOptions(shape.width, sub_pixels, 3).padding(1)),
      bounded_(shape.bounded) {
  const int width = shape.width;
  append_normalised(encode_, {sub_pixels + shape.extra_maps, width, 3});
  append_blocks(encode_blocks_, shape.blocks, width);
  append_normalised(fall_, nn::Conv2dOptions(width, 2 * width, 3).stride(2));
  append_blocks(bottom_blocks_, shape.bottom_blocks, 2 * width);
  append_blocks(decode_blocks_, shape.blocks, width);
  nn::init::normal_(start_->weight, 0, first_map_weight);
  nn::init::zeros_(start_->bias);
  register_module("start", start_);
  register_module("encode", encode_);
  register_module("encode_blocks", encode_blocks_);
  register_module("fall", fall_);
  register_module("bottom_blocks", bottom_blocks_);
  register_module("rise", rise_);
  register_module("decode_blocks", decode_blocks_);
  register_module("image", image_);
  if (bounded_) {
    nn::init::constant_(image_->bias, untouched_logit);
  } else {
    // The correction starts near zero, so that the first image is the dense layer's.
    nn::init::uniform_(image_->weight, -first_correction, first_correction);
    nn::init::zeros_(image_->bias);
  }
}

torch::Tensor LeanNet::blocks(nn::Sequential& convolutions, torch::Tensor maps) {
  for (std::size_t i = 0; i < convolutions->size(); i += 2) {
    auto* const convolution = convolutions[i]->as<nn::Conv2d>();
    auto* const normalisation = convolutions[i + 1]->as<nn::BatchNorm2d>();
    maps = (maps + normalisation->forward(convolution->forward(maps))).relu();
  }
  return maps;
}

torch::Tensor LeanNet::means_of_pairs(const torch::Tensor& frames) {
  pairs_ = pairs_.to(frames.device());
  return (frames.index_select(1, pairs_.select(1, 0)) +
          frames.index_select(1, pairs_.select(1, 1))) /
         2;
}

void LeanNet::set_first_image(const torch::Tensor& weights, const torch::Tensor& bias) {
  const torch::NoGradGuard no_gradients;
  const std::int64_t pixels = sub_pixels * rows_ * columns_;
  // Pixels of the image in the order of the dense layer's outputs: sub-pixel by sub-pixel.
  const torch::Tensor order =
      torch::arange(pixels).view({rows_, 2, columns_, 2}).permute({1, 3, 0, 2}).reshape({pixels});
  start_->weight.slice(0, 0, pixels).copy_(weights.index_select(0, order));
  start_->bias.slice(0, 0, pixels).copy_(bias.index_select(0, order));
}

torch::Tensor LeanNet::forward(const torch::Tensor& frames) {
  // Not the number of frames, which would be a constant of a traced graph.
  const std::int64_t maps = start_->weight.size(0) / (rows_ * columns_);
  const torch::Tensor start =
      start_->forward(means_of_pairs(frames)).view({-1, maps, rows_, columns_});
  const torch::Tensor half = blocks(encode_blocks_, encode_->forward(start).relu());
  const torch::Tensor quarter = blocks(bottom_blocks_, fall_->forward(half).relu());
  const torch::Tensor up = blocks(decode_blocks_, (half + rise_->forward(quarter)).relu());
  torch::Tensor image = image_->forward(up).to(torch::kFloat32);
  if (!bounded_) image = image + start.slice(1, 0, sub_pixels).to(torch::kFloat32);
  image = nn::functional::pixel_shuffle(image, nn::functional::PixelShuffleFuncOptions(2));
  return bounded_ ? image.sigmoid() : image;
}

std::unique_ptr<InferencePlan> LeanNet::plan(PlanBuilder plan) const {
  const Activation relu{Activation::Kind::relu, {}};
  const auto layer = [&](const nn::Sequential& layers, std::size_t index) {
    return weights_of(*layers->ptr(index)->as<nn::Conv2d>(),
                      layers->ptr(index + 1)->as<nn::BatchNorm2d>());
  };
  const auto blocks = [&](const nn::Sequential& layers, int maps) {
    for (std::size_t i = 0; i < layers->size(); i += 2) {
      ConvolutionWeights weights = layer(layers, i);
      // The identity of a block is one more weight at the kernel's centre.
      for (int o = 0; o < weights.outputs; ++o) {
        weights.weights[static_cast<std::size_t>((o * weights.inputs + o) * 9 + 4)] += 1;
      }
      maps = plan.convolution({maps}, std::move(weights), relu);
    }
    return maps;
  };
  const int means = plan.means_of_pairs(plan.input(inputs_), integers_of(pairs_));
  const DenseWeights dense = weights_of(*start_, nullptr);
  const int start =
      plan.maps(plan.dense(means, dense, {}), dense.outputs / (rows_ * columns_), rows_, columns_);
  const int half = blocks(encode_blocks_, plan.convolution({start}, layer(encode_, 0), relu));
  const int quarter = blocks(bottom_blocks_, plan.convolution({half}, layer(fall_, 0), relu));
  const int up = blocks(decode_blocks_, plan.transposed_convolution(
                                            quarter, weights_of(*rise_, nullptr), relu, half));
  const int maps = plan.image_convolution(up, weights_of(*image_, nullptr));
  const int image = plan.shuffle(maps, bounded_ ? PlanBuilder::none : start);
  return plan.finish(bounded_ ? plan.sigmoid(image) : image);
}

}  // namespace ertbench
