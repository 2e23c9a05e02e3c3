#pragma once

#include <cstdint>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/scene_model.h"

namespace ertbench {

class DatasetFile;

/// The spec of a set whose random sequence can be continued behind its last scene. Throws
/// InputError if its scenes are listed, measured or sequences.
DatasetSpec continued_spec(const DatasetFile& file);

/// Scenes that continue a training set's random sequence, as examples for a training: each turned
/// by a random symmetry of the sensor, with the set's noise and the faults of its sheet. A scene
/// depends only on the set and its number, its turn and its noise also on `seed`.
class FreshScenes {
 public:
  /// Throws InputError as continued_spec.
  FreshScenes(const DatasetFile& file, std::uint64_t seed, int threads);

  struct Block {
    Frames changes;        ///< [count, channels] V, from the set's reference
    Images image_changes;  ///< [count, pixels] S/m
  };
  /// The next `count` scenes.
  Block next(std::uint64_t count);

 private:
  DatasetSpec spec_;
  Eigen::VectorXd reference_;
  SceneModel model_;
  std::uint64_t seed_;
  std::uint64_t number_;  ///< of the next scene
  int threads_;
};

}  // namespace ertbench
