#include "models/inference/convolution_kernel.h"

namespace ertbench {
namespace {

/// `step`: from one pixel's input to the next one's, floats; 0: known when it runs.
template <typename Vector, int blocks, int rows, int columns, int step>
void convolve(const ConvolutionView& view, const ConvolutionTile& tile) {
  constexpr int width = sizeof(Vector) / sizeof(float);
  Vector sums[blocks][rows][columns];
  for (int b = 0; b < blocks; ++b) {
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        if (view.accumulate) {
          load(sums[b][r][c],
               tile.output + b * view.output_block + r * view.output_row + c * view.output_pixel);
        } else {
          load(sums[b][r][c], tile.bias + b * lanes);
        }
        if (tile.added) {
          Vector added;
          load(added,
               tile.added + b * view.added_block + r * view.added_row + c * view.added_pixel);
          sums[b][r][c] += added;
        }
      }
    }
  }
  const float* weights = view.weights;
  const std::ptrdiff_t pixel = step > 0 ? step : view.stride * view.input_pixel;
  const std::ptrdiff_t row = view.stride * view.input_row;
  for (int i = 0; i < view.input_count; ++i) {
    const float* from = tile.workspace + view.inputs[i] + tile.input;
    for (int ky = 0; ky < view.kernel; ++ky, from += view.input_row) {
      const float* x = from;
      for (int kx = 0; kx < view.kernel; ++kx, x += view.input_pixel, weights += blocks * width) {
        Vector weight[blocks];
        for (int b = 0; b < blocks; ++b) load(weight[b], weights + b * width);
#pragma GCC unroll 4
        for (int r = 0; r < rows; ++r) {
#pragma GCC unroll 12
          for (int c = 0; c < columns; ++c) {
            const float value = x[r * row + c * pixel];
#pragma GCC unroll 4
            for (int b = 0; b < blocks; ++b) sums[b][r][c] += weight[b] * value;
          }
        }
      }
    }
  }
  for (int b = 0; b < blocks; ++b) {
    Vector slope{};
    if (view.activation == Activation::Kind::prelu) load(slope, tile.slopes + b * lanes);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        if (view.activation == Activation::Kind::relu) relu(sums[b][r][c]);
        if (view.activation == Activation::Kind::prelu) leaky_relu(sums[b][r][c], slope);
        store(tile.output + b * view.output_block + r * view.output_row + c * view.output_pixel,
              sums[b][r][c]);
      }
    }
  }
}

template <typename Vector, int blocks, int rows, int columns>
TileShape shape(int stride, bool planar) {
  const int step = stride * (planar ? 1 : lanes);
  if (step == lanes) return {rows, columns, convolve<Vector, blocks, rows, columns, lanes>};
  if (step == 2 * lanes) return {rows, columns, convolve<Vector, blocks, rows, columns, 2 * lanes>};
  if (step == 1) return {rows, columns, convolve<Vector, blocks, rows, columns, 1>};
  return {rows, columns, convolve<Vector, blocks, rows, columns, 0>};
}

/// The largest shapes first: the more sums a tile has, the less often weights and pixels are read.
template <typename Vector, int blocks>
TileShape largest(int rows, int columns, int stride, bool planar) {
  if constexpr (register_tile >= 24) {
    if constexpr (blocks == 1) {
      if (columns >= 12 && rows >= 2) return shape<Vector, blocks, 2, 12>(stride, planar);
      if (columns >= 8 && rows >= 2) return shape<Vector, blocks, 2, 8>(stride, planar);
      if (columns >= 6 && rows >= 4) return shape<Vector, blocks, 4, 6>(stride, planar);
      if (columns >= 4 && rows >= 4) return shape<Vector, blocks, 4, 4>(stride, planar);
    }
    if (columns >= 12) return shape<Vector, blocks, 1, 12>(stride, planar);
    if (columns >= 8) return shape<Vector, blocks, 1, 8>(stride, planar);
    if (columns >= 6 && rows >= 2) return shape<Vector, blocks, 2, 6>(stride, planar);
    if (columns >= 4 && rows >= 2) return shape<Vector, blocks, 2, 4>(stride, planar);
  }
  if constexpr (register_tile >= 24 || blocks == 1) {
    if (columns >= 6) return shape<Vector, blocks, 1, 6>(stride, planar);
    if (columns >= 4) return shape<Vector, blocks, 1, 4>(stride, planar);
  }
  if (columns >= 3) return shape<Vector, blocks, 1, 3>(stride, planar);
  if (columns >= 2) return shape<Vector, blocks, 1, 2>(stride, planar);
  return shape<Vector, blocks, 1, 1>(stride, planar);
}

}  // namespace

int most_kernel_blocks() { return 2; }

TileShape tile_kernel(int blocks, bool half, int rows, int columns, int stride, bool planar) {
  if (half) return largest<Float8, 1>(rows, columns, stride, planar);
  if (blocks == 2) return largest<Float16, 2>(rows, columns, stride, planar);
  return largest<Float16, 1>(rows, columns, stride, planar);
}

}  // namespace ertbench
