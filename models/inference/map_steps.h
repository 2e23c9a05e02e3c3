#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "models/inference/inference_plan.h"

/// Dense layers, attention, and steps that are small beside these and convolutions.
namespace ertbench {

/// What is done in the workspace with some values of a plan, by their layouts.
using MapFunction = std::function<void(float* workspace, Layouts values)>;

class MapStep final : public PlanStep {
 public:
  /// `values` are handed to the function in their order, without those that are PlanBuilder::none.
  MapStep(std::vector<int> values, MapFunction function)
      : values_(std::move(values)), function_(std::move(function)) {}
  void prepare(Layouts layouts) override {
    for (const int value : values_) {
      if (value != PlanBuilder::none) layouts_.push_back(layouts[static_cast<std::size_t>(value)]);
    }
  }
  void run(float* workspace) const override { function_(workspace, layouts_); }

 private:
  std::vector<int> values_;
  MapFunction function_;
  std::vector<MapLayout> layouts_;
};

// The last value is written, unless it says otherwise.

/// Permutes the numbers of a vector; -1 gives 0.
MapFunction gather_numbers(std::vector<int> sources);
/// Means of pairs of a vector's numbers; `pairs` [outputs][2].
MapFunction mean_pairs(std::vector<int> pairs);
/// A vector as planar maps with their border.
void lay_maps(float* workspace, Layouts values);
/// Maximum over each 2 x 2 pixels of blocked maps.
void pool_maps(float* workspace, Layouts values);
/// Interleaves four planar maps to one of twice the side, the second value, with map
/// 2 (row % 2) + column % 2 at row, column, and adds the same of four others, if there is a third.
void shuffle_maps(float* workspace, Layouts values);
/// 1 / (1 + exp(-x)) of planar maps, in place.
void sigmoid_maps(float* workspace, Layouts values);
/// The mean of a mixture: estimates, weighted by the probabilities of their components. Values:
/// whitened coordinates, which are overwritten, the vector, the mean.
MapFunction average_mixture(DenseWeights estimates);
/// Initialises blocked maps, the first value, with the bias [16 blocks] and the added value, if
/// there is a second, for passes that add to them.
MapFunction fill_maps(std::vector<float> bias);

/// y = activation(W x + b). Reads its weights once, sequentially: for each group of outputs, whose
/// sums are in registers, input by input. With `bfloat16` they have that precision.
MapFunction multiply_dense(const DenseWeights& layer, Activation::Kind activation, bool bfloat16);

/// Spatial attention (B2 of the DD-ERT supplement) on blocked maps:
///
///     y = x sigmoid(convolution of [mean over the channels; maximum over the channels]).
///
/// The second value is the summary: two planar maps with a border of half the kernel, which are
/// filled here; `weights` [2][kernel][kernel].
MapFunction attend_maps(int kernel, std::vector<float> weights);

}  // namespace ertbench
