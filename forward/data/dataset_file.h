#pragma once

#include <Eigen/Core>
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

/// Names and row layouts inside a dataset file, shared by what writes and what reads it.
namespace ertbench::dataset_layout {

/// Version 1 had the recipe in an attribute of the root, which ends at 64 kB.
inline constexpr int schema_version = 2;

inline const std::string voltages = "/voltages";                      // [N, channels] V, noisy
inline const std::string clean_voltages = "/clean_voltages";          // [N, channels] V
inline const std::string reference_voltages = "/reference_voltages";  // [channels] V
inline const std::string conductivity = "/conductivity";              // [N, grid, grid] S/m
/// [N, contacts, 7]: kind, centre x, centre y, size a, size b, angle, conductivity ratio; NaN rows
/// are absent, as are the sizes and the angle of a polygon, whose centre is that of its area.
inline const std::string contacts = "/contacts";
/// [N, contacts, vertices, 2], NaN where absent; only where the set may hold polygons.
inline const std::string contact_vertices = "/contact_vertices";
/// [N, contacts] N, NaN where absent; of touches alone.
inline const std::string forces = "/forces";
/// [N] s since the beginning of the frame's sequence, and [N] the sequence's number; of sequences
/// alone.
inline const std::string time = "/time";
inline const std::string sequence = "/sequence";
/// Attribute of the root of measured sets: which of "images" and "places" are known.
inline const std::string truth = "truth";
/// One string: the canonical JSON of the DatasetSpec.
inline const std::string recipe = "/recipe";
/// [1]: rows that are whole, from the first.
inline const std::string scenes_written = "/scenes_written";

/// [N, 2]: points of the border integral equation, estimated error in V; with "grid": "auto" alone.
inline const std::string model_effort = "/model_effort";

inline constexpr Eigen::Index contact_columns = 7;
inline constexpr Eigen::Index effort_columns = 2;

/// Contacts that a row of /contacts has room for, at least one.
std::uint64_t contact_width(const DatasetSpec& spec);
/// Of /model_effort, which only "grid": "auto" has; else 0.
std::uint64_t effort_columns_of(const DatasetSpec& spec);

/// The forces of a scene's contacts.
void pack_forces(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> row);
/// Gives contacts, as unpack has them, their forces.
void unpack_forces(const Eigen::Ref<const Eigen::RowVectorXd>& row, Scene& scene);

/// One scene as rows of /contacts and /contact_vertices, flattened.
void pack(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> contact_row,
          Eigen::Ref<Eigen::RowVectorXd> vertex_row);
Scene unpack(const Eigen::Ref<const Eigen::RowVectorXd>& contact_row,
             const Eigen::Ref<const Eigen::RowVectorXd>& vertex_row);

}  // namespace ertbench::dataset_layout

namespace ertbench {

class SceneModel;

/// Scenes of a set as arrays, rows [first, first + count): what a block of the file holds.
struct DatasetBlock {
  Frames voltages;        ///< [count, channels] V, with noise and faults
  Frames clean_voltages;  ///< [count, channels] V, with faults of the sheet alone
  Images conductivity;    ///< [count, image pixels] S/m, the truth
  RowMajorMatrix effort;  ///< [count, 2] of SceneModel::solve; no columns for a grid
  RowMajorMatrix contacts;
  RowMajorMatrix vertices;
  RowMajorMatrix forces;      ///< [count, contacts] N; no columns where nothing has a force
  RowMajorMatrix moments;     ///< [count, 2] /time and /sequence; no columns where nothing moves
  std::vector<Scene> truths;  ///< [count]
};

/// `model` has the spec's sensor and SheetModel. The numbers depend on the spec alone, not on
/// threads or on where blocks begin.
DatasetBlock generate_block(const DatasetSpec& spec, const SceneModel& model, std::uint64_t first,
                            std::uint64_t count, int threads = 1);

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
