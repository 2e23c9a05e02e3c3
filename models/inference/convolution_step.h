#pragma once

#include <vector>

#include "models/inference/convolution_kernel.h"
#include "models/inference/inference_plan.h"

namespace ertbench {

/// Which pixels of the output a convolution writes: (first_row + step y, first_column + step x).
/// All of them by default; a transposed convolution is several convolutions that write some.
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
  /// Some blocks of output channels that are computed together.
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

}  // namespace ertbench
