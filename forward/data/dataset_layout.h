#pragma once

#include <cstdint>
#include <string>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/sheet/scene.h"

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
