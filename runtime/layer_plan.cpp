#include "runtime/layer_plan.h"

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace ertbench::runtime {
namespace {

using Kind = Layer::Kind;
constexpr int most_side = 1 << 14;
constexpr int most_numbers = 1 << 26;  ///< of a value

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(std::string("its layers do not fit together: ") + what);
}

std::size_t product(std::initializer_list<int> factors) {
  std::size_t out = 1;
  for (const int factor : factors) out *= static_cast<std::size_t>(factor);
  return out;
}

/// Builds a plan from the values of a list.
class Builder {
 public:
  explicit Builder(const LayerList& list) : list_(list) {
    require(!list.layers.empty(), "there are none");
    // What is read as an image, pixel by pixel; a convolution to such maps has kernels of its own.
    planar_.insert(list.layers.back().value);
    for (const Layer& layer : list.layers) {
      if (layer.kind != Kind::shuffle && layer.kind != Kind::sigmoid) continue;
      planar_.insert(layer.inputs.begin(), layer.inputs.end());
    }
  }

  std::unique_ptr<InferencePlan> finish(int inputs, int outputs) {
    for (const Layer& layer : list_.layers) {
      require(size_of(layer) <= most_numbers, "a value is too large");
      values_[layer.value] = add(layer);
    }
    require(layout(list_.layers.front().value).width == inputs, "the first one's inputs");
    const MapLayout& last = layout(list_.layers.back().value);
    require(product({last.channels, last.height, last.width}) == product({outputs}),
            "the last one's outputs");
    return builder_.finish(values_.at(list_.layers.back().value));
  }

 private:
  static std::size_t size_of(const Layer& layer) {
    for (const int side : {layer.channels, layer.height, layer.width, layer.kernel, layer.stride}) {
      require(side >= 1 && side <= most_side, "a size");
    }
    require(layer.padding >= 0 && layer.padding < layer.kernel, "a padding");
    return product({layer.channels, layer.height, layer.width});
  }
  int value(int index) const {
    const auto found = values_.find(index);
    require(found != values_.end(), "a value that no layer makes");
    return found->second;
  }
  int input(const Layer& layer) const {
    require(layer.inputs.size() == 1, "the number of inputs");
    return value(layer.inputs[0]);
  }
  const MapLayout& layout(int index) const { return builder_.layout(value(index)); }
  int vector(const Layer& layer) const {
    const int from = input(layer);
    require(builder_.layout(from).height == 1 && builder_.layout(from).channels == 1, "a vector");
    return from;
  }

  static Activation activation(const Layer& layer) {
    if (!layer.slopes.empty()) return {Activation::Kind::prelu, layer.slopes};
    return {layer.relu ? Activation::Kind::relu : Activation::Kind::none};
  }

  ConvolutionWeights weights(const Layer& layer) const {
    int inputs = 0;
    for (const int one : layer.inputs) {
      inputs += layout(one).channels;
      require(layout(one).height == layout(layer.inputs[0]).height &&
                  layout(one).width == layout(layer.inputs[0]).width,
              "sizes of maps that are convolved together");
    }
    require(layer.weights.size() == product({layer.channels, inputs, layer.kernel, layer.kernel}) &&
                layer.bias.size() == product({layer.channels}) &&
                (layer.slopes.empty() || layer.slopes.size() == layer.bias.size()),
            "weights of a convolution");
    if (layer.added >= 0) {
      const MapLayout& added = layout(layer.added);
      require(added.channels == layer.channels && added.height == layer.height &&
                  added.width == layer.width,
              "maps that are added");
    }
    return {inputs,        layer.channels, layer.kernel, layer.stride,
            layer.padding, layer.weights,  layer.bias};
  }

  int convolve(const Layer& layer) {
    require(!layer.inputs.empty(), "a convolution of nothing");
    ConvolutionWeights all = weights(layer);
    std::vector<int> inputs;
    for (const int one : layer.inputs) inputs.push_back(value(one));
    require(all.kernel <= layout(layer.inputs[0]).height + 2 * all.padding &&
                all.kernel <= layout(layer.inputs[0]).width + 2 * all.padding,
            "a kernel");
    if (planar_.count(layer.value) > 0) {
      require(
          inputs.size() == 1 && layer.added < 0 && activation(layer).kind == Activation::Kind::none,
          "a convolution to an image");
      return builder_.image_convolution(inputs[0], std::move(all));
    }
    return builder_.convolution(std::move(inputs), std::move(all), activation(layer), added(layer));
  }
  int added(const Layer& layer) const {
    return layer.added < 0 ? PlanBuilder::none : value(layer.added);
  }

  int add(const Layer& layer) {
    const int made = make(layer);
    const MapLayout& is = builder_.layout(made);
    require(is.channels == layer.channels && is.height == layer.height && is.width == layer.width,
            "a layer's sizes");
    return made;
  }

  int make(const Layer& layer) {
    switch (layer.kind) {
      case Kind::input:
        return builder_.input(layer.width);
      case Kind::dense: {
        const int from = vector(layer);
        const int inputs = builder_.layout(from).width;
        require(layer.weights.size() == product({layer.width, inputs}) &&
                    layer.bias.size() == product({layer.width}) && layer.slopes.empty(),
                "weights of a dense layer");
        return builder_.dense(from, {inputs, layer.width, layer.weights, layer.bias},
                              activation(layer));
      }
      case Kind::gather:
      case Kind::means_of_pairs: {
        const int from = vector(layer);
        const int least = layer.kind == Kind::gather ? -1 : 0;
        for (const int i : layer.indices) {
          require(i >= least && i < builder_.layout(from).width, "an index");
        }
        require(least < 0 || layer.indices.size() % 2 == 0, "a pair");
        return least < 0 ? builder_.gather(from, layer.indices)
                         : builder_.means_of_pairs(from, layer.indices);
      }
      case Kind::maps:
        return builder_.maps(vector(layer), layer.channels, layer.height, layer.width);
      case Kind::convolution:
        return convolve(layer);
      case Kind::transposed_convolution:
        return builder_.transposed_convolution(input(layer), weights(layer), activation(layer),
                                               added(layer));
      case Kind::pool:
        return builder_.pool(input(layer));
      case Kind::attention:
        require(layer.weights.size() == product({2, layer.kernel, layer.kernel}) &&
                    layer.kernel % 2 == 1,
                "weights of an attention");
        return builder_.attention(input(layer), layer.kernel, layer.weights);
      case Kind::shuffle:
        if (layer.added >= 0) {
          const MapLayout& added = layout(layer.added);
          require(2 * added.height == layer.height && 2 * added.width == layer.width &&
                      added.channels >= 4,
                  "maps that are added");
        }
        return builder_.shuffle(input(layer), added(layer));
      case Kind::sigmoid:
        return builder_.sigmoid(input(layer));
      case Kind::mixture:
        require(layer.inputs.size() == 2 && layout(layer.inputs[0]).height == 1 &&
                    layout(layer.inputs[0]).channels == 1 && layout(layer.inputs[1]).height == 1 &&
                    layout(layer.inputs[1]).channels == 1,
                "vectors of a mixture");
        return builder_.mixture(
            value(layer.inputs[0]), value(layer.inputs[1]),
            {layout(layer.inputs[1]).width, layer.width, layer.weights, layer.bias});
    }
    throw std::runtime_error("has a layer of a kind that this version does not know");
  }

  const LayerList& list_;
  std::set<int> planar_;
  std::map<int, int> values_;  ///< of the list: the builder's
  PlanBuilder builder_;
};

}  // namespace

std::unique_ptr<InferencePlan> plan_of(const LayerList& list, int inputs, int outputs) {
  try {
    return Builder(list).finish(inputs, outputs);
  } catch (const std::logic_error& error) {
    throw std::runtime_error(error.what());
  }
}

}  // namespace ertbench::runtime
