#pragma once

#include <memory>
#include <vector>

#include "models/inference/inference_plan.h"

namespace ertbench {

/// What follows a layer's sum. `slopes`: of a PReLU, one for each output.
struct Activation {
  enum class Kind { none, relu, prelu };
  Kind kind = Kind::none;
  std::vector<float> slopes = {};
};

/// `weights` [outputs][inputs], `bias` [outputs].
struct DenseWeights {
  int inputs = 0;
  int outputs = 0;
  std::vector<float> weights;
  std::vector<float> bias;
};

/// `weights` [outputs][inputs][kernel][kernel], `bias` [outputs]. Transposed convolutions, too: as
/// libtorch has them the other way round, whoever builds a plan turns them.
struct ConvolutionWeights {
  int inputs = 0;
  int outputs = 0;
  int kernel = 0;
  int stride = 1;
  int padding = 0;
  std::vector<float> weights;
  std::vector<float> bias;
};

/// A transposed convolution of stride 1 as a convolution: the kernel turned by half a circle.
ConvolutionWeights turned(ConvolutionWeights weights);

/// Makes an InferencePlan layer by layer. Functions take and return numbers of values, vectors or
/// stacks of maps; sizes that do not fit together throw std::logic_error, as they are a network's
/// mistake, not a user's.
class PlanBuilder {
 public:
  /// With `bfloat16` the weights of dense layers are kept in that; sums stay float32.
  explicit PlanBuilder(bool bfloat16 = false) : bfloat16_(bfloat16) {}

  int input(int size);
  int dense(int vector, DenseWeights weights, const Activation& activation);
  /// Numbers of a vector in another order; `sources` with -1 give 0.
  int gather(int vector, std::vector<int> sources);
  /// The means of pairs of a vector's numbers.
  int means_of_pairs(int vector, std::vector<int> pairs);
  /// A vector as planar maps.
  int maps(int vector, int channels, int height, int width);
  /// A convolution of all channels of `inputs`, one after the other, plus `added` where it is one.
  int convolution(std::vector<int> inputs, ConvolutionWeights weights, const Activation& activation,
                  int added = none);
  /// A convolution of stride 1 to at most four planar maps.
  int image_convolution(int maps, ConvolutionWeights weights);
  int transposed_convolution(int maps, ConvolutionWeights weights, const Activation& activation,
                             int added = none);
  /// The largest of each 2 x 2 pixels.
  int pool(int maps);
  /// SpatialAttention: `weights` [2][kernel][kernel], of the map of means and of that of maxima.
  int attention(int maps, int kernel, std::vector<float> weights);
  /// 4 planar maps to 1 of twice the side, plus the same of the first 4 of `added`, where it is
  /// one.
  int shuffle(int maps, int added = none);
  /// In place.
  int sigmoid(int maps);

  const MapLayout& layout(int value) const { return values_.at(static_cast<std::size_t>(value)); }
  /// Ends the building. `output` is planar.
  std::unique_ptr<InferencePlan> finish(int output);

  static constexpr int none = -1;

 private:
  int add(const MapLayout& layout);
  int vector(int size) { return add({.width = size, .planar = true}); }
  void widen_border(int value, int border);
  template <typename Step, typename... Arguments>
  void step(Arguments&&... arguments);
  void make_like(const std::vector<int>& inputs);

  bool bfloat16_;
  std::vector<MapLayout> values_;
  std::vector<std::vector<int>> alike_;  ///< values that must have one border
  std::vector<std::unique_ptr<PlanStep>> steps_;
};

}  // namespace ertbench
