#include "models/inference/convolution_kernel.h"

#include <algorithm>

namespace ertbench {
namespace {

/// `width`: lanes of a block that are computed, all 16 or 8. `step`: from one pixel's input to the
/// next one's, floats; 0: known when it runs.
template <int width, int blocks, int rows, int columns, int step>
void convolve(const ConvolutionView& view, const ConvolutionTile& tile) {
  using Vector = Floats<std::min(width, native_lanes)>;
  constexpr int count = sizeof(Vector) / sizeof(float);
  constexpr int parts = width / count;     // vectors of a block
  constexpr int vectors = blocks * parts;  // of a pixel
  Vector sums[vectors][rows][columns];
#pragma GCC unroll 8
  for (int v = 0; v < vectors; ++v) {
    const int block = v / parts;
    const int lane = v % parts * count;
#pragma GCC unroll 4
    for (int r = 0; r < rows; ++r) {
#pragma GCC unroll 12
      for (int c = 0; c < columns; ++c) {
        if (view.accumulate) {
          load(sums[v][r][c], tile.output + block * view.output_block + r * view.output_row +
                                  c * view.output_pixel + lane);
        } else {
          load(sums[v][r][c], tile.bias + block * lanes + lane);
        }
        if (tile.added) {
          Vector added;
          load(added, tile.added + block * view.added_block + r * view.added_row +
                          c * view.added_pixel + lane);
          sums[v][r][c] += added;
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
        Vector weight[vectors];
#pragma GCC unroll 8
        for (int v = 0; v < vectors; ++v) load(weight[v], weights + v * count);
#pragma GCC unroll 4
        for (int r = 0; r < rows; ++r) {
#pragma GCC unroll 12
          for (int c = 0; c < columns; ++c) {
            const float value = x[r * row + c * pixel];
#pragma GCC unroll 8
            for (int v = 0; v < vectors; ++v) sums[v][r][c] += weight[v] * value;
          }
        }
      }
    }
  }
#pragma GCC unroll 8
  for (int v = 0; v < vectors; ++v) {
    const int block = v / parts;
    const int lane = v % parts * count;
    Vector slope{};
    if (view.activation == Activation::Kind::prelu) load(slope, tile.slopes + block * lanes + lane);
#pragma GCC unroll 4
    for (int r = 0; r < rows; ++r) {
#pragma GCC unroll 12
      for (int c = 0; c < columns; ++c) {
        if (view.activation == Activation::Kind::relu) relu(sums[v][r][c]);
        if (view.activation == Activation::Kind::prelu) leaky_relu(sums[v][r][c], slope);
        store(tile.output + block * view.output_block + r * view.output_row +
                  c * view.output_pixel + lane,
              sums[v][r][c]);
      }
    }
  }
}

template <int width, int blocks, int rows, int columns>
TileShape shape(int stride, bool planar) {
  const int step = stride * (planar ? 1 : lanes);
  if (step == lanes) return {rows, columns, convolve<width, blocks, rows, columns, lanes>};
  if (step == 2 * lanes) return {rows, columns, convolve<width, blocks, rows, columns, 2 * lanes>};
  if (step == 1) return {rows, columns, convolve<width, blocks, rows, columns, 1>};
  return {rows, columns, convolve<width, blocks, rows, columns, 0>};
}

/// The first shape of the list that fits into what is left of the map and into the registers.
template <int width, int blocks>
struct Shapes {
  int rows;
  int columns;
  int stride;
  bool planar;

  template <int some_rows, int some_columns>
  bool take(TileShape& found) const {
    constexpr int vectors = blocks * width / std::min(width, native_lanes);
    if constexpr (vectors * some_rows * some_columns <= sum_registers || some_columns == 1) {
      if (found.kernel || rows < some_rows || columns < some_columns) return false;
      found = shape<width, blocks, some_rows, some_columns>(stride, planar);
      return true;
    } else {
      return false;
    }
  }
};

/// The largest shapes first: the more sums a tile has, the less often weights and pixels are read.
/// What is right of a strip of columns is left for narrower ones.
template <int width, int blocks>
TileShape largest(int rows, int columns, int stride, bool planar) {
  const Shapes<width, blocks> shapes{rows, columns, stride, planar};
  TileShape found{1, 1, nullptr};
  shapes.template take<2, 12>(found) || shapes.template take<1, 12>(found) ||
      shapes.template take<2, 8>(found) || shapes.template take<1, 8>(found) ||
      shapes.template take<4, 6>(found) || shapes.template take<2, 6>(found) ||
      shapes.template take<1, 6>(found) || shapes.template take<4, 4>(found) ||
      shapes.template take<2, 4>(found) || shapes.template take<1, 4>(found) ||
      shapes.template take<1, 3>(found) || shapes.template take<1, 2>(found) ||
      shapes.template take<1, 1>(found);
  return found;
}

}  // namespace

TileShape tile_kernel(int blocks, bool half, int rows, int columns, int stride, bool planar) {
  if (half) return largest<lanes / 2, 1>(rows, columns, stride, planar);
  if constexpr (most_kernel_blocks > 1) {
    if (blocks == 2) return largest<lanes, 2>(rows, columns, stride, planar);
  }
  return largest<lanes, 1>(rows, columns, stride, planar);
}

}  // namespace ertbench
