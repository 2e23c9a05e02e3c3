#include "models/networks/fcnn.h"

#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/linear.h>

#include "models/networks/plan_layers.h"

namespace ertbench {

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

Fcnn::Fcnn(const Sensor& sensor, const std::vector<int>& widths)
    : inputs_(sensor.channels()), rows_(sensor.image_rows()), columns_(sensor.image_columns()) {
  const int last = append_dense_layers(layers_, sensor.channels(), widths);
  layers_->push_back(nn::Linear(last, sensor.pixels()));
  register_module("layers", layers_);
}

torch::Tensor Fcnn::forward(const torch::Tensor& frames) {
  return layers_->forward(frames).view({-1, 1, rows_, columns_});
}

std::unique_ptr<InferencePlan> Fcnn::plan(bool bfloat16) const {
  PlanBuilder plan(bfloat16);
  const int image = add_layers(plan, layers_, {plan.input(inputs_)});
  return plan.finish(plan.maps(image, 1, rows_, columns_));
}

}  // namespace ertbench
