#pragma once

#include <torch/types.h>

#include <memory>
#include <vector>

#include "forward/data/dataset_spec.h"
#include "forward/sheet/symmetry.h"
#include "models/training/epoch_scenes.h"
#include "models/training/standardisation.h"
#include "models/training/training_settings.h"

namespace ertbench {

class DatasetFile;

/// Standardised frames and the true images, y = (1 - sigma / background) / Standardisation::image.
struct TrainingBatch {
  torch::Tensor frames;  ///< [batch, channels]
  torch::Tensor truths;  ///< [batch, 1, rows, columns]
};

/// The training scenes, in another order, turned by other symmetries, and with other noise and
/// faults in every epoch. What a batch holds depends on (seed, epoch, position) alone, so that an
/// interrupted training goes on as it would have gone.
class TrainingSet {
 public:
  /// Reads the whole file: 3.1 kB a scene. With `new_scenes` later epochs draw scenes that continue
  /// the file's own random sequence (EpochScenes). Throws InputError where they cannot be drawn
  /// anew.
  TrainingSet(const DatasetFile& file, const Standardisation& standardisation,
              const TrainingSettings& settings);

  std::uint64_t size() const { return static_cast<std::uint64_t>(clean_.rows()); }

  /// See sheet_mask.
  const torch::Tensor& mask() const { return mask_; }

  /// Makes an epoch's scenes and their order; epochs count from 0.
  void begin_epoch(std::uint64_t epoch);
  /// The scenes at [first, first + count) of the epoch's order.
  TrainingBatch batch(std::uint64_t first, std::uint64_t count) const;

 private:
  using FloatRows = EpochScenes::FloatRows;

  DatasetSpec spec_;
  Standardisation standardisation_;
  std::uint64_t seed_;
  TrainingFaults faults_;
  std::vector<Symmetry> symmetries_;         ///< the identity alone where they are off
  std::unique_ptr<EpochScenes> new_scenes_;  ///< null where every epoch has the file's
  Eigen::VectorXd reference_;
  FloatRows clean_;   ///< [scenes, channels] V
  FloatRows truths_;  ///< [scenes, pixels] y
  torch::Tensor mask_;
  std::uint64_t epoch_ = 0;
  std::uint64_t scenes_of_epoch_ = 0;  ///< whose scenes the arrays hold
  std::vector<std::uint32_t> order_;
};

}  // namespace ertbench
