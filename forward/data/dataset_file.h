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

namespace ertbench {

class Hdf5File;

}  // namespace ertbench

/// Names and row layouts inside a dataset file, shared by its writer and its reader.
namespace ertbench::dataset_layout {

/// Version 1 had the recipe in an attribute of the root, which is limited to 64 kB.
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
/// [N, contacts] N, NaN if absent; only for touches.
inline const std::string forces = "/forces";
/// [N] s since the beginning of the frame's sequence, and [N] the sequence's number; only for
/// sequences.
inline const std::string time = "/time";
inline const std::string sequence = "/sequence";
/// Root attribute of measured sets: lists which of "images" and "places" are known.
inline const std::string truth = "truth";
/// One string: the canonical JSON of the DatasetSpec.
inline const std::string recipe = "/recipe";
/// [1]: number of complete rows, from the first.
inline const std::string scenes_written = "/scenes_written";

/// [N, 2]: points of the border integral equation, estimated error in V; only with "grid": "auto".
inline const std::string model_effort = "/model_effort";

inline constexpr Eigen::Index contact_columns = 7;
inline constexpr Eigen::Index effort_columns = 2;

/// Number of contacts in a row of /contacts, at least one.
std::uint64_t contact_width(const DatasetSpec& spec);
/// Columns of /model_effort; 0 without it.
std::uint64_t effort_columns_of(const DatasetSpec& spec);

/// Writes the forces of a scene's contacts to a row of /forces.
void pack_forces(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> row);
/// Reads the forces of unpacked contacts from a row of /forces.
void unpack_forces(const Eigen::Ref<const Eigen::RowVectorXd>& row, Scene& scene);

/// One scene as rows of /contacts and /contact_vertices, flattened.
void pack(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> contact_row,
          Eigen::Ref<Eigen::RowVectorXd> vertex_row);
Scene unpack(const Eigen::Ref<const Eigen::RowVectorXd>& contact_row,
             const Eigen::Ref<const Eigen::RowVectorXd>& vertex_row);

/// The scenes of rows of a file's /contacts and, if it has them, /contact_vertices.
std::vector<Scene> read_scenes(const Hdf5File& file, std::uint64_t first, std::uint64_t count);

}  // namespace ertbench::dataset_layout

namespace ertbench {

class SceneModel;

/// A block of scenes [first, first + count) as arrays.
struct DatasetBlock {
  Frames voltages;        ///< [count, channels] V, with noise and faults
  Frames clean_voltages;  ///< [count, channels] V, without noise, with faults of the sheet only
  Images conductivity;    ///< [count, image pixels] S/m, the truth
  RowMajorMatrix effort;  ///< [count, 2] of SceneModel::solve; no columns for a grid
  RowMajorMatrix contacts;
  RowMajorMatrix vertices;
  RowMajorMatrix forces;      ///< [count, contacts] N; no columns without forces
  RowMajorMatrix moments;     ///< [count, 2] /time and /sequence; no columns without sequences
  std::vector<Scene> truths;  ///< [count]
};

/// Generates a block. `model` must have the spec's sensor and SheetModel. The numbers depend only
/// on the spec, not on threads or blocks.
DatasetBlock generate_block(const DatasetSpec& spec, const SceneModel& model, std::uint64_t first,
                            std::uint64_t count, int threads = 1);

/// A complete dataset file, opened for reading. Opening checks the shapes of all arrays; each read
/// checks its values. Errors are InputErrors naming file and HDF5 object.
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
  /// Why the contents differ from what was written (Hdf5File::why_changed); empty if they do not.
  /// Reads the whole file.
  std::string why_changed() const;
  /// The build that wrote the file; no value if it is not recorded.
  const std::optional<BuildStamp>& build() const { return build_; }
  /// The known truth. Without positions `scenes` are empty; without images `conductivity` shows
  /// declared contacts.
  Truth truth() const { return truth_; }
  /// The spec that the recipe describes. Throws InputError if the file has none.
  DatasetSpec spec() const;

  const Eigen::VectorXd& reference_voltages() const { return reference_; }  ///< [channels] V
  Frames voltages(std::uint64_t first, std::uint64_t count) const;          ///< with noise, V
  Frames clean_voltages(std::uint64_t first, std::uint64_t count) const;    ///< without, V
  Images conductivity(std::uint64_t first, std::uint64_t count) const;      ///< truth, S/m
  /// Estimated 2-norms of the errors of the clean voltages, [count] V; empty for a set on a grid.
  Eigen::VectorXd model_errors(std::uint64_t first, std::uint64_t count) const;
  std::vector<Scene> scenes(std::uint64_t first, std::uint64_t count) const;
  /// For sequences: [count] s since the beginning of each frame's sequence, and [count] the
  /// sequence's number; else empty.
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

/// The recipe of a complete or unfinished file; empty if it has none.
std::string written_recipe(const Hdf5File& file);

/// The build that wrote a complete or unfinished file: its root attribute "build" (JSON).
std::optional<BuildStamp> written_build(const Hdf5File& file);

/// The sensor in a file's root attribute "sensor" (JSON), or the default sensor without one.
Sensor sensor_of(const Hdf5File& file);

}  // namespace ertbench
