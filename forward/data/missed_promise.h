#pragma once

#include <cstdint>
#include <string>

#include "forward/data/dataset_spec.h"

namespace ertbench {

class DatasetFile;

/// How many scenes of a set have voltages whose estimated error is above what "model_error" allows.
struct MissedPromise {
  std::uint64_t scenes = 0;
  std::uint64_t of = 0;      ///< scenes in the set
  double model_error = 0;    ///< allowed, as a fraction of each scene's noise
  bool is_noisy = true;      ///< else the noise is that of 80 dB (see noise_norm)
  double largest_error = 0;  ///< of those scenes, V

  /// "3 of 500 scenes have voltages whose estimated error is above 0.05 of the noise, at most
  /// 0.0012 V"; empty where there are none.
  std::string sentence() const;
};

/// From the file's /model_effort; none where it has none, as on a grid. `spec` is the file's.
MissedPromise missed_promise(const DatasetSpec& spec, const DatasetFile& file);

}  // namespace ertbench
