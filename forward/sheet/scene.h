#pragma once

#include <Eigen/Geometry>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "forward/sheet/patch_field.h"

namespace ertbench {

/// Of a contact's conductivity over the background's. Less is an insulator as good as any, and
/// would leave nothing of the stiffness of its elements.
inline constexpr std::array<double, 2> conductivity_ratios = {1e-6, 1000};
/// Of a contact's radius, half axis or half side, domain units: no contact needs more or less, and
/// areas, boxes and their inverses are finite.
inline constexpr std::array<double, 2> contact_lengths = {1e-6, 100};

class JsonObject;

enum class Shape { disc = 0, ellipse = 1, rectangle = 2, polygon = 3 };

/// One pressed region of the sheet. Lengths in domain units (see Sheet).
struct Contact {
  Shape shape = Shape::disc;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< unused for a polygon
  /// Semi-axes of an ellipse, half sides of a rectangle, (radius, radius) for a disc;
  /// unused for a polygon.
  Eigen::Vector2d half_size = Eigen::Vector2d::Zero();
  double angle = 0;                       ///< of the first axis against x, counter-clockwise, rad
  std::vector<Eigen::Vector2d> vertices;  ///< of a polygon: absolute, in order, not self-crossing
  double conductivity_ratio = 1;          ///< sigma / background inside the contact, > 0
  /// Of a touch of the skin, N: the shape is its footprint and the conductivity that of the scene's
  /// patches, of which the ratio is the one that changed most. 0 where nothing is known of a force.
  double force_N = 0;

  /// Corners of the smallest axis-parallel box around the contact.
  Eigen::AlignedBox2d bounds() const;
  bool contains(const Eigen::Vector2d& point) const;
  /// Centre of area; a polygon's is computed from its vertices.
  Eigen::Vector2d centroid() const;
};

/// What presses on the sheet. Where contacts overlap, the lowest conductivity ratio counts, so that
/// the order of the contacts means nothing; what lies outside the sheet is cut off.
///
/// On a skin (Skin) the patches have the conductivities, and the contacts say what was pressed
/// where.
struct Scene {
  std::vector<Contact> contacts;
  std::optional<PatchField> patches = {};
};

/// `{"contacts": [{"shape": "ellipse", "centre": [x, y], "semi_axes": [a, b], "angle": radians,
/// "conductivity_ratio": 0.6}]}`; a `disc` has `radius`, a `rectangle` `half_sides`, a `polygon`
/// `vertices` in place of a centre.
Scene scene_from_json(JsonObject object);
nlohmann::json to_json(const Scene& scene);

const char* name_of(Shape shape);
Shape shape_named(const std::string& name);  ///< one of the four names

}  // namespace ertbench
