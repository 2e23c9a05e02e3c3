#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

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

struct GenerateOptions {
  int threads = 1;
  /// Called from the calling thread with the number of scenes on disk, from time to time.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;
};

/// Writes the dataset file of `spec`, a block of scenes at a time, so that memory does not grow
/// with the count. The numbers depend on the spec alone, not on threads or blocks.
///
/// The file grows under the name `file`.part, in which storage is reserved first and only raw data
/// and the count of whole rows are written later: it can be cut off at any moment, is refused by
/// every reader until it is whole, and a second call with the same spec goes on where the first
/// stopped. The finished file is renamed to `file`. Of several processes that write the same file
/// one does and the others wait for it. A file that holds
/// this very dataset, from a program with the same probes (data_probes), is left as it is; any
/// other is replaced.
/// Throws InputError where the folder cannot be written or the disk is too small.
void generate_dataset(const DatasetSpec& spec, const std::filesystem::path& file,
                      const GenerateOptions& options = {});

/// Throws InputError unless a dataset may be written as `file`, a name of the user's: nothing
/// stands there and under its name while it grows, or datasets, and it is none of the `inputs`
/// (require_output).
void require_dataset_output(const std::filesystem::path& file,
                            const std::vector<std::filesystem::path>& inputs);

}  // namespace ertbench
