#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench::differential {

using Random = std::mt19937;

/// Frames in files of one kind. The first frames are without contact and the rest touched.
enum class Reader { text, hdf5, eit };
inline constexpr Eigen::Index quiet_frames = 20;
inline constexpr Eigen::Index touched_frames = 6;

/// What a user holds in his hands, and how he writes it down and calls the program.
struct Recording {
  Reader reader = Reader::text;
  Sensor sensor;
  Frames frames;           ///< [N, columns]
  Frames reference;        ///< [1 or N, columns] of an HDF5 file; in others the first rows are it
  std::vector<int> sound;  ///< [N] the sound frame that each frame is made of

  std::string separator = ",";
  char decimal = '.';
  int digits = 10;
  std::string before;                ///< lines before the first frame
  std::string line_begin, line_end;  ///< of each line
  bool turned = false;               ///< frames are columns
  std::vector<std::uint64_t> shape;  ///< of an array in HDF5; empty: [N, columns]
  std::string options;
};

/// A recording of six discs at places on the sheet [touched_frames], with noise of 70 dB.
Recording sound_recording(Reader reader, unsigned seed);
/// The places of its contacts, mm from the sheet's middle.
std::vector<Eigen::Vector2d> places_of(unsigned seed);

/// Writes the recording into a folder and returns the name of the file or folder of frames.
std::string write(const Recording& recording, const std::filesystem::path& folder);
/// The lines of a text of frames.
std::string text_of(const Recording& recording);

/// A change of a recording; false if it cannot be made of this one.
struct Mistake {
  std::string name;
  std::function<bool(Recording&, Random&)> make;
  bool harmless = false;  ///< the answer must stay right, without a flag
};
const std::vector<Mistake>& mistakes();

}  // namespace ertbench::differential
