#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/scene_model.h"

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

}  // namespace ertbench
