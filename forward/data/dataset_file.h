#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "core/build_stamp.h"
#include "forward/data/dataset_spec.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

class Hdf5File;

/// A complete dataset file, opened to read. All arrays are checked for their shapes when it is
/// opened; each read checks its values. Errors are InputErrors naming file and HDF5 object.
class DatasetFile {
 public:
  explicit DatasetFile(const std::filesystem::path& file);
  DatasetFile(DatasetFile&&) noexcept;
  ~DatasetFile();

  const Sensor& sensor() const { return sensor_; }
  std::uint64_t size() const { return size_; }  ///< scenes
  const std::filesystem::path& path() const { return path_; }
  /// The canonical JSON that determines the file (DatasetSpec, sensor, seeds, versions), as text.
  const std::string& recipe() const { return recipe_; }
  /// Why the file is not what was written (Hdf5File::why_changed); empty where it is. Reads all of
  /// it.
  std::string why_changed() const;
  /// The build that wrote the file; nothing where it does not say.
  const std::optional<BuildStamp>& build() const { return build_; }
  /// What is known of the frames beside their voltages; of a set without contacts in its truth
  /// `scenes` are empty, of one without images `conductivity` shows declared contacts.
  Truth truth() const { return truth_; }
  /// The spec that the recipe describes. Throws InputError where the file has none.
  DatasetSpec spec() const;

  const Eigen::VectorXd& reference_voltages() const { return reference_; }  ///< [channels] V
  Frames voltages(std::uint64_t first, std::uint64_t count) const;          ///< with noise, V
  Frames clean_voltages(std::uint64_t first, std::uint64_t count) const;    ///< without, V
  Images conductivity(std::uint64_t first, std::uint64_t count) const;      ///< truth, S/m
  /// Estimated 2-norms of the errors of the clean voltages, [count] V; empty for a set on a grid.
  Eigen::VectorXd model_errors(std::uint64_t first, std::uint64_t count) const;
  std::vector<Scene> scenes(std::uint64_t first, std::uint64_t count) const;
  /// Of sequences: [count] s since the beginning of each frame's sequence, and [count] its number;
  /// empty for scenes that do not move.
  Eigen::VectorXd times(std::uint64_t first, std::uint64_t count) const;
  Eigen::VectorXd sequences(std::uint64_t first, std::uint64_t count) const;

 private:
  std::filesystem::path path_;
  std::unique_ptr<Hdf5File> file_;
  Sensor sensor_;
  std::uint64_t size_ = 0;
  std::string recipe_;
  std::optional<BuildStamp> build_;
  Truth truth_;
  Eigen::VectorXd reference_;
};

/// The recipe that a file, whole or not, was written by; empty where it does not say.
std::string written_recipe(const Hdf5File& file);

/// The build that wrote a file, whole or not: its root attribute "build" (JSON).
std::optional<BuildStamp> written_build(const Hdf5File& file);

/// The sensor that a file's root attribute "sensor" describes in JSON, or the default sensor where
/// there is none.
Sensor sensor_of(const Hdf5File& file);

}  // namespace ertbench
