#pragma once

#include <cstdint>
#include <vector>

#include "core/arrays.h"
#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "forward/data/measured_frames.h"

namespace ertbench {

/// A file of measured frames (MeasuredFrames), opened with its shapes checked. Throws InputError
/// naming the file and the HDF5 object.
class MeasuredFile {
 public:
  MeasuredFile(const std::filesystem::path& file, const Sensor& sensor);

  std::uint64_t size() const { return size_; }  ///< frames
  Truth truth() const { return truth_; }
  std::uint64_t contacts() const { return contacts_; }  ///< contacts in a row

  /// Frames, reference and truths of the given rows. Frames with references of their own are
  /// shifted to the mean reference, which keeps their changes.
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
  std::uint64_t columns_ = 0;  ///< columns of a contact; 0 if only positions are known
};

/// A set of measured frames, read as a whole, because measured sets are small.
class MeasuredBlocks {
 public:
  explicit MeasuredBlocks(const DatasetSpec& spec);

  const Eigen::VectorXd& reference_voltages() const { return content_.reference; }
  /// Frames [first, first + count), like generate_block. Measured voltages are not changed: noise
  /// in the spec is for trainings that draw it in every epoch.
  DatasetBlock block(std::uint64_t first, std::uint64_t count) const;

 private:
  const DatasetSpec& spec_;
  MeasuredFile::Content content_;
};

}  // namespace ertbench
