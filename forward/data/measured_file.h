#pragma once

#include <cstdint>
#include <vector>

#include "core/arrays.h"
#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "forward/data/measured_frames.h"

namespace ertbench {

/// A file of measured frames (MeasuredFrames), opened and checked for the shapes of what it holds.
/// Throws InputError naming the file and the HDF5 object.
class MeasuredFile {
 public:
  MeasuredFile(const std::filesystem::path& file, const Sensor& sensor);

  std::uint64_t size() const { return size_; }  ///< frames
  Truth truth() const { return truth_; }
  std::uint64_t contacts() const { return contacts_; }  ///< that a frame has room for

  /// Frames, references and truths of some rows in their order. Frames that have a reference of
  /// their own are moved to the mean of these, so that all changes are what they were against one
  /// reference.
  struct Content {
    Frames voltages;            ///< [rows, channels] V
    Eigen::VectorXd reference;  ///< [channels] V
    Images conductivity;        ///< [rows, pixels] S/m
    std::vector<Scene> scenes;  ///< [rows]
  };
  Content read(const MeasuredFrames& frames, const Sensor& sensor,
               const std::vector<std::uint64_t>& rows) const;

 private:
  RowMajorMatrix rows_of(const std::string& dataset, const std::vector<std::uint64_t>& rows,
                         bool allow_nan = false) const;
  std::vector<Scene> scenes_of(const MeasuredFrames& frames, const Sensor& sensor,
                               const std::vector<std::uint64_t>& rows) const;
  Scene scene_of(const MeasuredFrames& frames, const Sensor& sensor, double strength,
                 const Eigen::Ref<const Eigen::RowVectorXd>& values) const;

  Hdf5File file_;
  std::uint64_t size_ = 0;
  bool own_references_ = false;
  Truth truth_;
  std::uint64_t contacts_ = 1;
  std::uint64_t columns_ = 0;  ///< of a contact; 0 where places alone are known
};

/// What a set of measured frames is made of, read as a whole: measured sets are small.
class MeasuredBlocks {
 public:
  explicit MeasuredBlocks(const DatasetSpec& spec);

  const Eigen::VectorXd& reference_voltages() const { return content_.reference; }
  /// Frames [first, first + count), as generate_block makes those of other sets. What was measured
  /// stays as it is: noise that the spec declares is for those who draw it anew in every epoch.
  DatasetBlock block(std::uint64_t first, std::uint64_t count) const;

 private:
  const DatasetSpec& spec_;
  MeasuredFile::Content content_;
};

}  // namespace ertbench
