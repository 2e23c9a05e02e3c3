#include "models/networks/eit_nn.h"

#include <torch/nn/init.h>
#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>

#include "models/networks/fcnn.h"
#include "models/networks/plan_layers.h"

namespace ertbench {

namespace nn = torch::nn;

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
  // The target is nearly empty: a first image of noise takes longer to unlearn than all the rest to
  // learn.
  nn::init::uniform_(image->weight, -first_weight, first_weight);
  convolutions_->push_back(image);
  register_module("dense", dense_);
  register_module("convolutions", convolutions_);
}

torch::Tensor EitNn::forward(const torch::Tensor& frames) {
  return convolutions_->forward(dense_->forward(frames).view({-1, 1, rows_, columns_}));
}

std::unique_ptr<InferencePlan> EitNn::plan(bool bfloat16) const {
  PlanBuilder plan(bfloat16);
  const int dense = add_layers(plan, dense_, {plan.input(inputs_)});
  return plan.finish(add_layers(plan, convolutions_, {plan.maps(dense, 1, rows_, columns_)}, true));
}

}  // namespace ertbench
