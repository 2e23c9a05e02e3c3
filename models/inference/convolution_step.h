#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "models/inference/inference_plan.h"
#include "models/inference/vectors.h"

namespace ertbench {

/// A convolution for some blocks of output channels, the input of kernels; all strides in floats.
struct ConvolutionView {
  const float* weights;          ///< [inputs][kernel][kernel][blocks][vector]
  const std::ptrdiff_t* inputs;  ///< where each input channel begins in the workspace, with
                                 ///< the first pixel that the first output's window meets
  int input_count;
  int kernel;
  std::ptrdiff_t input_row;  ///< from one row to the next
  std::ptrdiff_t input_pixel;
  int stride;                   ///< pixels of the input to one of the output
  std::ptrdiff_t output_block;  ///< from one block of channels to the next
  std::ptrdiff_t output_row;    ///< between rows that are written
  std::ptrdiff_t output_pixel;
  bool accumulate;             ///< begins with what stands in the output, without the bias
  std::ptrdiff_t added_block;  ///< of the map that is added
  std::ptrdiff_t added_row;
  std::ptrdiff_t added_pixel;
  Activation::Kind activation;
};

/// Position of one tile of the output.
struct ConvolutionTile {
  float* workspace;
  std::ptrdiff_t input;  ///< of the tile's first pixel from the map's
  float* output;
  const float* added;  ///< null: nothing is added
  const float* bias;   ///< [blocks][16]
  const float* slopes;
};

/// Computes a tile of `rows` x `columns` pixels and `blocks` blocks of channels with its sums in
/// registers.
using TileKernel = void (*)(const ConvolutionView&, const ConvolutionTile&);

struct TileShape {
  int rows;
  int columns;
  TileKernel kernel;
};

/// The best kernel of at most so many rows and columns. `half`: vectors of 8 lanes, for a last
/// block of at most 8 channels.
TileShape tile_kernel(int blocks, bool half, int rows, int columns, int stride, bool planar);

/// Number of blocks of channels that a kernel computes together: one if that fills the registers.
constexpr int most_kernel_blocks = sum_registers >= 24 ? 2 : 1;

/// Output pixels that a convolution writes: (first_row + step y, first_column + step x), by default
/// all. A transposed convolution is several convolutions that write a part each.
struct OutputPixels {
  int step = 1;
  int first_row = 0;
  int first_column = 0;
  bool accumulate = false;  ///< adds to what stands there
};

/// A convolution that computes 16 channels of some neighbouring pixels at a time, their sums in
/// registers, from maps with borders.
class ConvolutionStep final : public PlanStep {
 public:
  /// `added`: a value like the output that is added before the activation, or PlanBuilder::none.
  ConvolutionStep(std::vector<int> inputs, int output, ConvolutionWeights weights,
                  Activation activation, int added, const OutputPixels& pixels);
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  struct Tile {
    std::ptrdiff_t input;
    std::ptrdiff_t output;
    std::ptrdiff_t added;
    TileKernel kernel;
  };
  /// Blocks of output channels that are computed together.
  struct Group {
    ConvolutionView view;
    int first_block;
    std::vector<float> weights;
    std::vector<Tile> tiles;
  };

  void arrange(Group& group, int blocks, bool half) const;
  void cover(Group& group, int blocks, bool half, int rows, int columns, Layouts layouts) const;

  std::vector<int> inputs_;
  int output_;
  ConvolutionWeights weights_;  ///< as they came; empty once they are arranged
  Activation activation_;
  int added_;
  OutputPixels pixels_;
  std::vector<std::ptrdiff_t> channels_;
  std::vector<Group> groups_;
};

/// A convolution of stride 1 from blocked maps to at most four planar ones. With so few outputs the
/// lanes of a vector are 16 input channels, whose products are added at the end.
class NarrowConvolutionStep final : public PlanStep {
 public:
  static constexpr int most_outputs = 4;

  NarrowConvolutionStep(int input, int output, ConvolutionWeights weights)
      : input_(input), output_(output), shape_(std::move(weights)) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  template <int outputs, int pixels>
  void convolve(float* workspace, std::ptrdiff_t input, std::ptrdiff_t output) const;
  template <int outputs>
  void run_with(float* workspace) const;

  int input_;
  int output_;
  ConvolutionWeights shape_;
  std::vector<float> weights_;          ///< [block of inputs][kernel][kernel][outputs][16]
  std::vector<std::ptrdiff_t> blocks_;  ///< where each block of inputs begins
  MapLayout from_;
  MapLayout to_;
};

}  // namespace ertbench
