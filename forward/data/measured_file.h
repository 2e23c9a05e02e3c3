#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/arrays.h"
#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "forward/data/measured_frames.h"

namespace ertbench {

/// A file of measured frames (MeasuredFrames), opened with its shapes checked. Throws InputError
/// naming the file and the HDF5 object.
///
/// Presses without a reference are read as well: `/changes` [N, channels], or `/voltages` alone,
/// whose reference is each channel's median. Missing values (NaN) count as no change. Their
/// `/positions_mm` may have any origin: the sheet's centre is the middle of their extent.
class MeasuredFile {
 public:
  MeasuredFile(const std::filesystem::path& file, const Sensor& sensor);

  std::uint64_t size() const { return size_; }  ///< frames
  Truth truth() const { return truth_; }
  std::uint64_t contacts() const { return contacts_; }  ///< contacts in a row
  /// Of each press from the sheet's centre, [N, 2] mm; the file must have `/positions_mm`.
  RowMajorMatrix positions_mm() const;

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
  void check_shapes(std::uint64_t channels);
  /// Voltages and reference of presses without a reference.
  void read_changes(const std::vector<std::uint64_t>& rows, Content& out) const;
  RowMajorMatrix rows_of(const std::string& dataset, const std::vector<std::uint64_t>& rows,
                         bool allow_nan = false) const;
  std::vector<Scene> scenes_of(const MeasuredFrames& frames, const Sensor& sensor,
                               const std::vector<std::uint64_t>& rows) const;
  Scene scene_of(const MeasuredFrames& frames, const Sensor& sensor, double strength,
                 const Eigen::Ref<const Eigen::RowVectorXd>& values) const;

  Hdf5File file_;
  std::uint64_t size_ = 0;
  bool own_references_ = false;
  bool without_reference_ = false;
  Truth truth_;
  std::uint64_t contacts_ = 1;
  std::uint64_t columns_ = 0;  ///< columns of a contact; 0 if only positions are known
};

/// A sensor for a file of presses on a skin of which nothing else is known: a disc around all
/// presses, and as many channels as the file has, whose electrodes are stand-ins. For solvers that
/// learn from presses alone. Inspects the file in a child process; throws InputError.
Sensor sensor_of_presses(const std::filesystem::path& file);

/// What `look` returns, run in a child process, because the HDF5 library crashes on some damaged
/// files. Throws its InputErrors.
nlohmann::json inspected(const std::filesystem::path& file,
                         const std::function<nlohmann::json()>& look);

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
