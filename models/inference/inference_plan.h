#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/layers.h"
#include "models/inference/vectors.h"

namespace ertbench {

/// Layout of a stack of maps in the workspace, in floats. Each map has a border of zeros as wide as
/// the padding of the convolutions that read it, so that these need no special edges.
///
/// Blocked: [channels / 16][row][column][16]; lanes beyond the last channel are zero. Planar:
/// [channels][row][column], for images and for vectors, which are maps of one row.
struct MapLayout {
  int channels = 1;
  int height = 1;
  int width = 1;
  bool planar = false;
  int border = 0;
  std::ptrdiff_t offset = 0;  ///< of the first number of the border

  int blocks() const { return (channels + lanes - 1) / lanes; }
  std::ptrdiff_t pixel() const { return planar ? 1 : lanes; }
  std::ptrdiff_t row() const { return (width + 2 * border) * pixel(); }
  /// Distance between planes, or between blocks of channels.
  std::ptrdiff_t plane() const { return (height + 2 * border) * row(); }
  /// Offset of a channel's first pixel inside the border.
  std::ptrdiff_t channel(int index) const {
    const std::ptrdiff_t inside = offset + border * (row() + pixel());
    return planar ? inside + index * plane() : inside + index / lanes * plane() + index % lanes;
  }
  std::ptrdiff_t block(int index) const { return channel(index * lanes); }
  std::ptrdiff_t size() const { return (planar ? channels : blocks()) * plane(); }
};

using Layouts = std::span<const MapLayout>;

/// One layer of a plan, with its weights in the order of its kernel.
class PlanStep {
 public:
  virtual ~PlanStep() = default;
  /// Called once, when the layout of the maps is known.
  virtual void prepare(Layouts layouts) = 0;
  virtual void run(float* workspace) const = 0;
};

/// A network for the inference of single frames: a list of steps on preallocated buffers. Made by a
/// PlanBuilder.
class InferencePlan {
 public:
  InferencePlan(std::vector<std::unique_ptr<PlanStep>> steps, const MapLayout& input,
                const MapLayout& output, std::ptrdiff_t workspace);
  ~InferencePlan();

  /// `input` [inputs], `output` [outputs], a planar map row by row. Thread-safe: concurrent calls
  /// take workspaces from a pool, which grows on demand.
  void run(const float* input, float* output) const;

 private:
  class Workspace;
  std::unique_ptr<Workspace> take() const;
  void give_back(std::unique_ptr<Workspace> workspace) const;

  std::vector<std::unique_ptr<PlanStep>> steps_;
  MapLayout input_;
  MapLayout output_;
  std::ptrdiff_t size_;  ///< of a workspace, floats
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> free_;
};

/// Activation of a layer. `slopes`: of a PReLU, one for each output.
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

/// `weights` [outputs][inputs][kernel][kernel], `bias` [outputs]. Also for transposed convolutions,
/// whose first two dimensions libtorch has in the opposite order.
struct ConvolutionWeights {
  int inputs = 0;
  int outputs = 0;
  int kernel = 0;
  int stride = 1;
  int padding = 0;
  std::vector<float> weights;
  std::vector<float> bias;
};

/// A transposed convolution of stride 1 as a convolution, with the kernel rotated by 180 degrees.
ConvolutionWeights turned(ConvolutionWeights weights);

/// Builds an InferencePlan layer by layer. Functions take and return the indices of values, which
/// are vectors or stacks of maps. Sizes that do not match throw std::logic_error, a defect of the
/// network.
class PlanBuilder {
 public:
  /// With `bfloat16` the weights of dense layers have that precision; sums stay float32. The layers
  /// are also written to `recorded` unless that is null.
  explicit PlanBuilder(bool bfloat16 = false, std::vector<Layer>* recorded = nullptr)
      : bfloat16_(bfloat16), recorded_(recorded) {}

  int input(int size);
  int dense(int vector, DenseWeights weights, const Activation& activation);
  /// Permutes the numbers of a vector; -1 in `sources` gives 0.
  int gather(int vector, std::vector<int> sources);
  /// Means of pairs of a vector's numbers.
  int means_of_pairs(int vector, std::vector<int> pairs);
  /// A vector as planar maps.
  int maps(int vector, int channels, int height, int width);
  /// Convolution of the concatenated channels of `inputs`, plus `added` if that is a value.
  int convolution(std::vector<int> inputs, ConvolutionWeights weights, const Activation& activation,
                  int added = none);
  /// Convolution of stride 1 to at most four planar maps.
  int image_convolution(int maps, ConvolutionWeights weights);
  int transposed_convolution(int maps, ConvolutionWeights weights, const Activation& activation,
                             int added = none);
  /// Maximum over each 2 x 2 pixels.
  int pool(int maps);
  /// SpatialAttention: `weights` [2][kernel][kernel] of the maps of means and of maxima.
  int attention(int maps, int kernel, std::vector<float> weights);
  /// Interleaves 4 planar maps to 1 of twice the side, and adds the same of the first 4 maps of
  /// `added` if that is a value.
  int shuffle(int maps, int added = none);
  /// In place.
  int sigmoid(int maps);
  /// The mean of a mixture (Layer::Kind::mixture): `weights` and `bias` of all components.
  int mixture(int whitened, int vector, DenseWeights estimates);

  const MapLayout& layout(int value) const { return values_.at(static_cast<std::size_t>(value)); }
  /// Ends the building. `output` is planar.
  std::unique_ptr<InferencePlan> finish(int output);

  static constexpr int none = -1;

 private:
  int add(const MapLayout& layout);
  int vector(int size) { return add({.width = size, .planar = true}); }
  void widen_border(int value, int border);
  /// Records a layer that makes `value`.
  void record(Layer layer, int value);
  Layer layer_of(Layer::Kind kind, std::vector<int> inputs, const ConvolutionWeights& weights,
                 const Activation& activation, int added) const;
  template <typename Step, typename... Arguments>
  void step(Arguments&&... arguments);

  bool bfloat16_;
  std::vector<Layer>* recorded_;
  std::vector<MapLayout> values_;
  std::vector<std::vector<int>> alike_;  ///< values that must have one border
  std::vector<std::unique_ptr<PlanStep>> steps_;
};

}  // namespace ertbench
