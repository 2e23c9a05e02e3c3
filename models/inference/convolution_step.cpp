#include "models/inference/convolution_step.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace ertbench {
namespace {

/// `width`: computed lanes of a block, 16 or 8. `step`: distance between the inputs of neighbouring
/// pixels, floats; 0 if it is only known at run time.
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

/// The first shape of the list that fits into the rest of the map and into the registers.
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

/// Largest shapes first: the more sums a tile has, the less often weights and pixels are read.
/// Columns beyond a strip are left for narrower ones.
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

ConvolutionStep::ConvolutionStep(std::vector<int> inputs, int output, ConvolutionWeights weights,
                                 Activation activation, int added, const OutputPixels& pixels)
    : inputs_(std::move(inputs)),
      output_(output),
      weights_(std::move(weights)),
      activation_(std::move(activation)),
      added_(added),
      pixels_(pixels) {}

/// Reorders the weights of the group's outputs for its kernel.
void ConvolutionStep::arrange(Group& group, int blocks, bool half) const {
  const int width = half ? lanes / 2 : lanes;
  const int taps = weights_.kernel * weights_.kernel;
  for (int i = 0; i < weights_.inputs; ++i) {
    for (int tap = 0; tap < taps; ++tap) {
      for (int b = 0; b < blocks; ++b) {
        for (int lane = 0; lane < width; ++lane) {
          const int o = (group.first_block + b) * lanes + lane;
          const int at = (o * weights_.inputs + i) * taps + tap;
          group.weights.push_back(
              o < weights_.outputs ? weights_.weights[static_cast<std::size_t>(at)] : 0.0F);
        }
      }
    }
  }
}

/// Lists the group's tiles, strip of columns by strip.
void ConvolutionStep::cover(Group& group, int blocks, bool half, int rows, int columns,
                            Layouts layouts) const {
  const MapLayout& input = layouts[static_cast<std::size_t>(inputs_.front())];
  const MapLayout& output = layouts[static_cast<std::size_t>(output_)];
  const auto place = [&](const MapLayout& map, int y, int x) {
    return map.block(group.first_block) + (pixels_.first_row + y * pixels_.step) * map.row() +
           (pixels_.first_column + x * pixels_.step) * map.pixel();
  };
  for (int x = 0; x < columns;) {
    int width = 1;
    for (int y = 0; y < rows;) {
      const TileShape shape =
          tile_kernel(blocks, half, rows - y, columns - x, weights_.stride, input.planar);
      group.tiles.push_back({.input = weights_.stride * (y * input.row() + x * input.pixel()),
                             .output = place(output, y, x),
                             .added = added_ == PlanBuilder::none
                                          ? 0
                                          : place(layouts[static_cast<std::size_t>(added_)], y, x),
                             .kernel = shape.kernel});
      y += shape.rows;
      width = shape.columns;
    }
    x += width;
  }
}

void ConvolutionStep::prepare(Layouts layouts) {
  const MapLayout& input = layouts[static_cast<std::size_t>(inputs_.front())];
  const MapLayout& output = layouts[static_cast<std::size_t>(output_)];
  if (output.planar) throw std::logic_error("a wide convolution of a plan writes blocked maps");
  for (const int value : inputs_) {
    const MapLayout& map = layouts[static_cast<std::size_t>(value)];
    if (map.row() != input.row() || map.planar != input.planar || map.border < weights_.padding) {
      throw std::logic_error("the inputs of a plan's convolution are not alike");
    }
    for (int channel = 0; channel < map.channels; ++channel) {
      channels_.push_back(map.channel(channel) - weights_.padding * (map.row() + map.pixel()));
    }
  }
  const auto side = [&](int length) {
    return (length + 2 * weights_.padding - weights_.kernel) / weights_.stride + 1;
  };
  ConvolutionView view{.weights = nullptr,
                       .inputs = channels_.data(),
                       .input_count = weights_.inputs,
                       .kernel = weights_.kernel,
                       .input_row = input.row(),
                       .input_pixel = input.pixel(),
                       .stride = weights_.stride,
                       .output_block = output.plane(),
                       .output_row = pixels_.step * output.row(),
                       .output_pixel = pixels_.step * output.pixel(),
                       .accumulate = pixels_.accumulate,
                       .added_block = 0,
                       .added_row = 0,
                       .added_pixel = 0,
                       .activation = activation_.kind};
  if (added_ != PlanBuilder::none) {
    const MapLayout& added = layouts[static_cast<std::size_t>(added_)];
    view.added_block = added.plane();
    view.added_row = pixels_.step * added.row();
    view.added_pixel = pixels_.step * added.pixel();
  }
  for (int first = 0; first < output.blocks();) {
    const int left = weights_.outputs - first * lanes;
    const bool half = left <= lanes / 2;
    const int blocks =
        left > lanes + lanes / 2 ? std::min(most_kernel_blocks, output.blocks() - first) : 1;
    Group& group = groups_.emplace_back(Group{view, first, {}, {}});
    arrange(group, blocks, half);
    cover(group, blocks, half, side(input.height), side(input.width), layouts);
    first += blocks;
  }
  weights_.weights = {};
  weights_.bias.resize(static_cast<std::size_t>(output.blocks() * lanes));
  activation_.slopes.resize(static_cast<std::size_t>(output.blocks() * lanes));
  for (Group& group : groups_) group.view.weights = group.weights.data();
}

void ConvolutionStep::run(float* workspace) const {
  for (const Group& group : groups_) {
    const std::ptrdiff_t first = group.first_block * lanes;
    for (const Tile& tile : group.tiles) {
      tile.kernel(group.view,
                  {.workspace = workspace,
                   .input = tile.input,
                   .output = workspace + tile.output,
                   .added = added_ == PlanBuilder::none ? nullptr : workspace + tile.added,
                   .bias = weights_.bias.data() + first,
                   .slopes = activation_.slopes.data() + first});
    }
  }
}

void NarrowConvolutionStep::prepare(Layouts layouts) {
  from_ = layouts[static_cast<std::size_t>(input_)];
  to_ = layouts[static_cast<std::size_t>(output_)];
  const int taps = shape_.kernel * shape_.kernel;
  for (int block = 0; block < from_.blocks(); ++block) {
    blocks_.push_back(from_.block(block) - shape_.padding * (from_.row() + from_.pixel()));
    for (int tap = 0; tap < taps; ++tap) {
      for (int o = 0; o < shape_.outputs; ++o) {
        for (int i = block * lanes; i < (block + 1) * lanes; ++i) {
          const int at = (o * shape_.inputs + i) * taps + tap;
          weights_.push_back(i < shape_.inputs ? shape_.weights[static_cast<std::size_t>(at)]
                                               : 0.0F);
        }
      }
    }
  }
  shape_.weights = {};
}

template <int outputs, int pixels>
void NarrowConvolutionStep::convolve(float* workspace, std::ptrdiff_t input,
                                     std::ptrdiff_t output) const {
  Native sums[outputs][pixels] = {};
  const float* weights = weights_.data();
  const std::ptrdiff_t row = from_.row();
  for (const std::ptrdiff_t block : blocks_) {
    const float* from = workspace + block + input;
    for (int ky = 0; ky < shape_.kernel; ++ky, from += row) {
      const float* x = from;
      for (int kx = 0; kx < shape_.kernel; ++kx, x += lanes, weights += outputs * lanes) {
#pragma GCC unroll 4
        for (int v = 0; v < block_vectors; ++v) {
#pragma GCC unroll 8
          for (int p = 0; p < pixels; ++p) {
            Native values;
            load(values, x + p * lanes + v * native_lanes);
#pragma GCC unroll 4
            for (int o = 0; o < outputs; ++o) {
              Native weight;
              load(weight, weights + o * lanes + v * native_lanes);
              sums[o][p] += weight * values;
            }
          }
        }
      }
    }
  }
#pragma GCC unroll 4
  for (int o = 0; o < outputs; ++o) {
    float* to = workspace + to_.channel(o) + output;
#pragma GCC unroll 8
    for (int p = 0; p < pixels; ++p) {
      to[p] = sum(sums[o][p]) + shape_.bias[static_cast<std::size_t>(o)];
    }
  }
}

template <int outputs>
void NarrowConvolutionStep::run_with(float* workspace) const {
  constexpr int pixels = outputs > 2 ? sum_registers / 6 : sum_registers / 3;
  for (int y = 0; y < to_.height; ++y) {
    int x = 0;
    for (; x + pixels <= to_.width; x += pixels) {
      convolve<outputs, pixels>(workspace, y * from_.row() + x * lanes, y * to_.row() + x);
    }
    for (; x < to_.width; ++x) {
      convolve<outputs, 1>(workspace, y * from_.row() + x * lanes, y * to_.row() + x);
    }
  }
}

void NarrowConvolutionStep::run(float* workspace) const {
  switch (shape_.outputs) {
    case 1:
      return run_with<1>(workspace);
    case 2:
      return run_with<2>(workspace);
    case 3:
      return run_with<3>(workspace);
    default:
      return run_with<4>(workspace);
  }
}

}  // namespace ertbench
