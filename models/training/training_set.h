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
#include "solvers/front/front.h"

namespace ertbench {

class DatasetFile;

/// Scenes that continue a training set's random sequence, as many as the set has for each epoch.
/// Trainings on one set share them: each block is generated once, by the first training that needs
/// it, and cached in the folder SET.epochs beside the set's file (3.1 kB per scene). Concurrent
/// trainings share the work of an epoch.
class EpochScenes {
 public:
  struct Block {
    FloatRows clean;   ///< [scenes, channels] V, without noise
    FloatRows change;  ///< [scenes, pixels] 1 - sigma / background
  };

  /// Throws InputError if the set's scenes are listed, measured or sequences, which cannot be
  /// continued.
  explicit EpochScenes(const DatasetFile& file);

  /// Calls take(first, block) for all blocks of an epoch. Epochs count from 0, which has the file's
  /// scenes. Blocks that cannot be cached (a full disk) are used all the same, with one warning.
  void read(std::uint64_t epoch,
            const std::function<void(std::uint64_t first, const Block& block)>& take);

 private:
  std::filesystem::path file_of(std::uint64_t epoch, std::uint64_t block) const;
  Block made(std::uint64_t epoch, std::uint64_t block) const;
  /// Throws InputError unless the file is a complete block of this set.
  Block kept(const std::filesystem::path& file, std::uint64_t scenes) const;
  /// Requires the block's lock.
  void keep(const Block& block, const std::filesystem::path& file) const;

  DatasetSpec spec_;
  std::uint64_t size_;
  std::filesystem::path folder_;
  std::string checksum_;  ///< of the set; blocks of another set are generated again
  SceneModel model_;
  bool keeps_ = true;
};

/// Standardised frames and the true images, y = (1 - sigma / background) / Standardisation::image.
struct TrainingBatch {
  torch::Tensor frames;  ///< [batch, channels], and behind them what the front tells
  torch::Tensor truths;  ///< [batch, 1, rows, columns]
};

/// Training scenes with a new order, new symmetries, noise and faults in every epoch. A batch
/// depends only on (seed, epoch, position), so that an interrupted training continues unchanged.
class TrainingSet {
 public:
  /// Reads the whole file, 3.1 kB per scene. With `new_scenes` later epochs use scenes that
  /// continue the file's random sequence (EpochScenes). Throws InputError if that is impossible.
  /// `front` tells the network of each frame, unless it is null, and outlives this.
  TrainingSet(const DatasetFile& file, const Standardisation& standardisation,
              const TrainingSettings& settings, const Front* front = nullptr);

  std::uint64_t size() const { return static_cast<std::uint64_t>(clean_.rows()); }

  /// See sheet_mask.
  const torch::Tensor& mask() const { return mask_; }

  /// Prepares the scenes of an epoch and their order; epochs count from 0.
  void begin_epoch(std::uint64_t epoch);
  /// The scenes at [first, first + count) of the epoch's order.
  /// Drawn by `threads` threads; the batch does not depend on their number.
  TrainingBatch batch(std::uint64_t first, std::uint64_t count, int threads = 1) const;

 private:
  /// Draws the scene at `place` of the epoch's order. `voltages`: room for a frame.
  void draw(std::uint64_t place, Eigen::VectorXd& voltages, float* frame, float* truth) const;
  /// Puts level, gradient and displaced electrodes into the voltages of one frame.
  void change_sheet(const Faults& faults, RandomStream& random, Eigen::VectorXd& voltages) const;

  DatasetSpec spec_;
  Standardisation standardisation_;
  std::uint64_t seed_;
  TrainingFaults faults_;
  const Front* front_;
  int told_ = 0;
  /// [channels, 2 + electrodes] V of gradients and displaced electrodes, for size one.
  Eigen::MatrixXd responses_;
  std::vector<Symmetry> symmetries_;         ///< only the identity if they are off
  std::unique_ptr<EpochScenes> new_scenes_;  ///< null if every epoch has the file's scenes
  Eigen::VectorXd reference_;
  FloatRows clean_;   ///< [scenes, channels] V
  FloatRows truths_;  ///< [scenes, pixels] y
  torch::Tensor mask_;
  std::uint64_t epoch_ = 0;
  std::uint64_t scenes_of_epoch_ = 0;  ///< epoch whose scenes the arrays hold
  std::vector<std::uint32_t> order_;
};

/// Validation frames with a contact, with the noise of the file.
class ValidationSet {
 public:
  /// Throws InputError if no frame has a contact.
  ValidationSet(const DatasetFile& file, const Standardisation& standardisation,
                const Front* front = nullptr);

  struct Score {
    double error = 0;   ///< mean over the frames of |image - truth| / |truth|, conductivity changes
    double spread = 0;  ///< largest difference of a pixel between two frames' images
  };

  /// Puts the network into evaluation mode.
  /// `device`: that of the network.
  Score score(Network& network, torch::Device device = torch::kCPU) const;

 private:
  torch::Tensor frames_;
  torch::Tensor truths_;
  torch::Tensor mask_;  ///< see sheet_mask
};

}  // namespace ertbench
