#pragma once

#include <cstddef>
#include <span>

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

}  // namespace ertbench
