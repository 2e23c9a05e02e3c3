#include "models/networks/plan_layers.h"

#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/pooling.h>
#include <torch/types.h>

#include <stdexcept>
#include <utility>

#include "models/networks/network.h"

namespace ertbench {
namespace nn = torch::nn;
namespace {

std::vector<float> numbers_of(const torch::Tensor& tensor) {
  const torch::Tensor flat = tensor.detach().to(torch::kFloat32).contiguous();
  const float* first = flat.data_ptr<float>();
  return {first, first + flat.numel()};
}

/// Weights whose first dimension is the outputs, and bias.
struct FoldedLayer {
  torch::Tensor weights;
  torch::Tensor bias;

  /// In double precision, so that what is rounded is the product alone.
  FoldedLayer(const torch::Tensor& from, const torch::Tensor& offset)
      : weights(from.detach().to(torch::kFloat64)),
        bias(offset.defined() ? offset.detach().to(torch::kFloat64)
                              : torch::zeros({from.size(0)}, torch::kFloat64)) {}

  template <typename Normalisation>
  void fold(const Normalisation* normalisation) {
    if (!normalisation) return;
    const auto wide = [](const torch::Tensor& x) { return x.detach().to(torch::kFloat64); };
    const torch::Tensor scale =
        wide(normalisation->weight) *
        (wide(normalisation->running_var) + normalisation->options.eps()).rsqrt();
    bias = (bias - wide(normalisation->running_mean)) * scale + wide(normalisation->bias);
    std::vector<std::int64_t> shape(static_cast<std::size_t>(weights.dim()), 1);
    shape[0] = -1;
    weights = weights * scale.view(shape);
  }
};

/// Weights [outputs][inputs][kernel][kernel].
template <typename Options>
ConvolutionWeights convolution(const FoldedLayer& layer, const Options& options) {
  ConvolutionWeights out;
  out.outputs = static_cast<int>(layer.weights.size(0));
  out.inputs = static_cast<int>(layer.weights.size(1));
  out.kernel = static_cast<int>(layer.weights.size(2));
  out.stride = static_cast<int>(options.stride()->at(0));
  // A variant of c10's, or of the standard library's, by libtorch's version.
  const auto* padding = get_if<torch::ExpandingArray<2>>(&options.padding());
  if (!padding) throw std::logic_error("the padding of a convolution is not a number");
  out.padding = static_cast<int>((*padding)->at(0));
  out.weights = numbers_of(layer.weights);
  out.bias = numbers_of(layer.bias);
  return out;
}

/// The modules of a Sequential, one after the other.
class Modules {
 public:
  explicit Modules(const nn::Sequential& layers) {
    for (const auto& module : *layers) modules_.push_back(module.ptr());
  }
  bool done() const { return next_ == modules_.size(); }
  /// The next one, where it is such a module; else null.
  template <typename Module>
  auto take() -> decltype(std::declval<nn::Module&>().as<Module>()) {
    auto* const module = done() ? nullptr : modules_[next_]->as<Module>();
    if (module) ++next_;
    return module;
  }
  Activation activation() {
    if (take<nn::ReLU>()) return {Activation::Kind::relu, {}};
    if (const auto* prelu = take<PRelu>()) {
      return {Activation::Kind::prelu, numbers_of(prelu->slope())};
    }
    return {};
  }

 private:
  std::vector<std::shared_ptr<nn::Module>> modules_;
  std::size_t next_ = 0;
};

}  // namespace

DenseWeights weights_of(const nn::LinearImpl& layer, const nn::BatchNorm1dImpl* normalisation) {
  FoldedLayer folded(layer.weight, layer.bias);
  folded.fold(normalisation);
  return {static_cast<int>(layer.weight.size(1)), static_cast<int>(layer.weight.size(0)),
          numbers_of(folded.weights), numbers_of(folded.bias)};
}

ConvolutionWeights weights_of(const nn::Conv2dImpl& layer,
                              const nn::BatchNorm2dImpl* normalisation) {
  FoldedLayer folded(layer.weight, layer.bias);
  folded.fold(normalisation);
  return convolution(folded, layer.options);
}

ConvolutionWeights weights_of(const nn::ConvTranspose2dImpl& layer,
                              const nn::BatchNorm2dImpl* normalisation) {
  FoldedLayer folded(layer.weight.transpose(0, 1), layer.bias);
  folded.fold(normalisation);
  return convolution(folded, layer.options);
}

std::vector<int> integers_of(const torch::Tensor& tensor) {
  const torch::Tensor flat = tensor.to(torch::kCPU, torch::kInt32).contiguous();
  const int* first = flat.data_ptr<int>();
  return {first, first + flat.numel()};
}

int add_layers(PlanBuilder& plan, const nn::Sequential& layers, std::vector<int> inputs,
               bool to_image) {
  Modules modules(layers);
  while (!modules.done()) {
    int out = PlanBuilder::none;
    if (const auto* dense = modules.take<nn::Linear>()) {
      const auto* normalisation = modules.take<nn::BatchNorm1d>();
      out = plan.dense(inputs.at(0), weights_of(*dense, normalisation), modules.activation());
    } else if (const auto* same = modules.take<nn::Conv2d>()) {
      const auto* normalisation = modules.take<nn::BatchNorm2d>();
      const ConvolutionWeights weights = weights_of(*same, normalisation);
      const Activation activation = modules.activation();
      out = to_image && modules.done() ? plan.image_convolution(inputs.at(0), weights)
                                       : plan.convolution(inputs, weights, activation);
    } else if (const auto* larger = modules.take<nn::ConvTranspose2d>()) {
      const auto* normalisation = modules.take<nn::BatchNorm2d>();
      const ConvolutionWeights weights = weights_of(*larger, normalisation);
      const Activation activation = modules.activation();
      out = to_image && modules.done()
                ? plan.image_convolution(inputs.at(0), turned(weights))
                : plan.transposed_convolution(inputs.at(0), weights, activation);
    } else if (modules.take<nn::MaxPool2d>()) {
      out = plan.pool(inputs.at(0));
    } else {
      throw std::logic_error("a layer that no plan has");
    }
    inputs = {out};
  }
  return inputs.at(0);
}

}  // namespace ertbench
