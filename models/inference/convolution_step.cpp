#include "models/inference/convolution_step.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace ertbench {

ConvolutionStep::ConvolutionStep(std::vector<int> inputs, int output, ConvolutionWeights weights,
                                 Activation activation, int added, const OutputPixels& pixels)
    : inputs_(std::move(inputs)),
      output_(output),
      weights_(std::move(weights)),
      activation_(std::move(activation)),
      added_(added),
      pixels_(pixels) {}

/// Puts the weights of the group's outputs into the order in which its kernel reads them.
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

}  // namespace ertbench
