#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/check/check.h"

namespace ertbench {

/// Images that a solver once made of some frames, and makes again.
struct StoredImages {
  std::string row;               ///< of the line: "stored dcnn"
  std::filesystem::path spec;    ///< of the solver, as `reconstruct` takes it
  std::filesystem::path frames;  ///< HDF5
  std::filesystem::path before;  ///< the images as they are stored
  std::filesystem::path now;     ///< where today's go
  std::filesystem::path log;     ///< of the process that makes them
  double most = 0;               ///< largest relative change of a frame's image
};

/// Makes today's images in a process of its own; false where it failed.
bool make_images(const StoredImages& images);

/// A line with the largest relative difference (2-norm) of a frame's image, infinite where frames
/// or statuses are not the same; "worse" beyond `most`, or where there are no images of today,
/// "missing" where none are stored. Throws InputError where the stored images cannot be read.
CheckLine compare_images(const StoredImages& images);

/// A line "missing" for each of the `rows` that has none among `lines`.
void add_missing_images(const std::vector<std::string>& rows, std::vector<CheckLine>& lines);

}  // namespace ertbench
