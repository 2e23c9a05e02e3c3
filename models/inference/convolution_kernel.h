#pragma once

#include <cstddef>

#include "models/inference/plan_builder.h"
#include "models/inference/vectors.h"

namespace ertbench {

/// A convolution as its kernels see it: for some blocks of output channels, all strides in floats.
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

/// Where one tile of the output lies.
struct ConvolutionTile {
  float* workspace;
  std::ptrdiff_t input;  ///< of the tile's first pixel from the map's
  float* output;
  const float* added;  ///< null: nothing is added
  const float* bias;   ///< [blocks][16]
  const float* slopes;
};

/// Computes a tile of some `rows` x `columns` pixels and `blocks` blocks of channels, whose sums
/// are in registers.
using TileKernel = void (*)(const ConvolutionView&, const ConvolutionTile&);

struct TileShape {
  int rows;
  int columns;
  TileKernel kernel;
};

/// The best kernel of at most so many rows and columns. `half`: the vectors have 8 lanes, for a
/// last block of no more channels.
TileShape tile_kernel(int blocks, bool half, int rows, int columns, int stride, bool planar);

/// How many blocks of channels a kernel takes at a time: one where that fills the registers.
constexpr int most_kernel_blocks = sum_registers >= 24 ? 2 : 1;

}  // namespace ertbench
