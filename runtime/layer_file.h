#pragma once

#include <string>
#include <vector>

#include "core/frame_front.h"
#include "core/layers.h"

namespace ertbench::runtime {

/// What the file of a fitted solver holds: the layers, the sensor's numbers that they need, and the
/// rule by which contacts are read from an image.
struct LayerFile {
  std::string name;
  int channels = 0;
  int rows = 0;
  int columns = 0;
  std::vector<float> reference;  ///< [channels] V
  std::vector<int> no_sheet;     ///< pixels that are always zero
  float threshold = 0;           ///< of the largest change: less is no contact
  float floor = 0;               ///< S/m: less is no contact
  float saddle = 0;              ///< of the lower of two summits: less divides them
  float x_mm = 0;                ///< centre of the first pixel
  float y_mm = 0;
  float width_mm = 0;  ///< of a pixel
  float height_mm = 0;
  LayerList list;
  FrameFront front;  ///< of which the first layer has `told` inputs behind the channels
};

/// The bytes of a file: "ERTRUN2" and a newline, size and checksum (FNV-1a) of the rest in 8 bytes
/// each, then the numbers, little-endian, each list behind its length.
std::string bytes_of(const LayerFile& file);

/// Throws std::runtime_error for bytes that `bytes_of` did not write.
LayerFile layer_file_from(const std::string& bytes);

}  // namespace ertbench::runtime
