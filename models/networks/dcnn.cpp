#include "models/networks/dcnn.h"

#include <torch/nn/functional/padding.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/pooling.h>
#include <torch/types.h>

#include "core/errors.h"
#include "models/networks/plan_layers.h"
#include "models/networks/prelu.h"

namespace ertbench {
namespace nn = torch::nn;
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
  const torch::Tensor with_none =
      nn::functional::pad(frames, nn::functional::PadFuncOptions({0, 1}));
  return layers_->forward(with_none.index_select(1, source_).view({-1, 1, drives_, measurements_}));
}

std::unique_ptr<InferencePlan> Dcnn::plan(bool bfloat16) const {
  PlanBuilder plan(bfloat16);
  const torch::Tensor order = source_.contiguous();
  const std::int64_t* first = order.data_ptr<std::int64_t>();
  std::vector<int> sources;
  for (std::int64_t i = 0; i < order.numel(); ++i) {
    const int source = static_cast<int>(first[i]);
    sources.push_back(source == channels_ ? PlanBuilder::none : source);
  }
  const int map = plan.maps(plan.gather(plan.input(channels_), sources), 1, drives_, measurements_);
  return plan.finish(add_layers(plan, layers_, {map}, true));
}

}  // namespace ertbench
