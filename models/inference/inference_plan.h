#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "models/inference/vectors.h"

namespace ertbench {

/// Where the numbers of a stack of maps stand in the workspace, in floats. Around each map lies a
/// border of zeros as wide as the padding of the convolutions that read it, so that these have no
/// edges to look after.
///
/// Blocked: of a pixel, 16 channels stand side by side, [channels / 16][row][column][16]; lanes
/// past the last channel are zero. Planar: [channels][row][column], for images and for vectors,
/// which are maps of one row.
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
  /// From one plane, or one block of channels, to the next.
  std::ptrdiff_t plane() const { return (height + 2 * border) * row(); }
  /// Of one channel's first pixel inside the border.
  std::ptrdiff_t channel(int index) const {
    const std::ptrdiff_t inside = offset + border * (row() + pixel());
    return planar ? inside + index * plane() : inside + index / lanes * plane() + index % lanes;
  }
  std::ptrdiff_t block(int index) const { return channel(index * lanes); }
  std::ptrdiff_t size() const { return (planar ? channels : blocks()) * plane(); }
};

using Layouts = std::span<const MapLayout>;

/// One layer of a plan, with its weights as its kernel wants them.
class PlanStep {
 public:
  virtual ~PlanStep() = default;
  /// Called once, when it is known where the maps stand.
  virtual void prepare(Layouts layouts) = 0;
  virtual void run(float* workspace) const = 0;
};

/// A network laid out for the inference of single frames: a list of steps on buffers that are
/// allocated beforehand. Made by a PlanBuilder.
class InferencePlan {
 public:
  InferencePlan(std::vector<std::unique_ptr<PlanStep>> steps, const MapLayout& input,
                const MapLayout& output, std::ptrdiff_t workspace);
  ~InferencePlan();

  /// `input` [inputs], `output` [outputs], a planar map row by row. Thread-safe; each thread that
  /// is in here at a time has a workspace of its own, which is allocated when there is none left.
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
