#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "forward/data/dataset_spec.h"

namespace ertbench {

class DatasetFile;

/// Scenes of a set whose voltages have an estimated error above "model_error".
struct MissedPromise {
  std::uint64_t scenes = 0;
  std::uint64_t of = 0;      ///< scenes in the set
  double model_error = 0;    ///< allowed error, as a fraction of each scene's noise
  bool is_noisy = true;      ///< else 80 dB of noise are assumed (see noise_norm)
  double largest_error = 0;  ///< among those scenes, V

  /// "3 of 500 scenes have voltages whose estimated error is above 0.05 of the noise, at most
  /// 0.0012 V"; empty without such a scene.
  std::string sentence() const;
};

/// Reads the file's /model_effort; no scene is counted without it, as for a grid. `spec` is the
/// file's.
MissedPromise missed_promise(const DatasetSpec& spec, const DatasetFile& file);

struct GenerateOptions {
  int threads = 1;
  /// Called now and then, from the calling thread, with the number of scenes on disk.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;
};

/// Writes the dataset file of `spec` in blocks of scenes, so that memory does not grow with the
/// count. The numbers depend only on the spec, not on threads or blocks.
///
/// The file grows under the name `file`.part. Its storage is reserved first, then only data and the
/// count of complete rows are written, so that it may be cut off at any moment: readers refuse it
/// until it is complete, and another call with the same spec continues it. The finished file is
/// renamed to `file`. If several processes write the same file, one does and the others wait. A
/// file that holds this dataset, from a program with the same probes (data_probes), is kept; any
/// other is replaced. Throws InputError if the folder cannot be written or the disk is too small.
void generate_dataset(const DatasetSpec& spec, const std::filesystem::path& file,
                      const GenerateOptions& options = {});

/// Throws InputError unless a dataset may be written as `file`: that file and its unfinished form
/// do not exist or are datasets, and it is none of the `inputs` (require_output).
void require_dataset_output(const std::filesystem::path& file,
                            const std::vector<std::filesystem::path>& inputs);

}  // namespace ertbench
