#pragma once

#include <torch/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/scene_model.h"
#include "forward/sheet/sensor.h"
#include "models/networks/network.h"
#include "models/training/standardisation.h"
#include "models/training/training_settings.h"

namespace ertbench {

class DatasetFile;

/// The scenes that follow a training set's own in its random sequence, one lot of the set's size
/// for each epoch. Trainings on one set see the same ones, so that each block of them is made once,
/// by whichever training is the first to want it, and kept in the folder SET.epochs beside the
/// set's file: 3.1 kB a scene. Trainings at the same time share the making of an epoch.
class EpochScenes {
 public:
  using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  struct Block {
    FloatRows clean;   ///< [scenes, channels] V, without noise
    FloatRows change;  ///< [scenes, pixels] 1 - sigma / background
  };

  /// Throws InputError where the set's scenes are listed, measured or move, and cannot be drawn
  /// anew.
  explicit EpochScenes(const DatasetFile& file);

  /// Calls take(first, block) for all blocks of an epoch; epochs count from 0, whose scenes are the
  /// file's own. What cannot be kept (a full disk) is used all the same, and said once.
  void read(std::uint64_t epoch,
            const std::function<void(std::uint64_t first, const Block& block)>& take);

 private:
  std::filesystem::path file_of(std::uint64_t epoch, std::uint64_t block) const;
  Block made(std::uint64_t epoch, std::uint64_t block) const;
  /// Throws InputError where the file is not a block of this set, whole.
  Block kept(const std::filesystem::path& file, std::uint64_t scenes) const;
  /// Only with the block's lock.
  void keep(const Block& block, const std::filesystem::path& file) const;

  DatasetSpec spec_;
  std::uint64_t size_;
  std::filesystem::path folder_;
  std::string checksum_;  ///< the set's own: blocks of another one are made again
  SceneModel model_;
  bool keeps_ = true;
};

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

/// The validation frames that hold a contact, with the noise that the file gives them.
class ValidationSet {
 public:
  /// Throws InputError where no frame holds a contact.
  ValidationSet(const DatasetFile& file, const Standardisation& standardisation);

  struct Score {
    double error = 0;   ///< mean over the frames of |image - truth| / |truth|, conductivity changes
    double spread = 0;  ///< largest difference of a pixel between two frames' images
  };

  /// Puts the network into evaluation mode.
  Score score(Network& network) const;

 private:
  torch::Tensor frames_;
  torch::Tensor truths_;
  torch::Tensor mask_;  ///< see sheet_mask
};

}  // namespace ertbench
