#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/skin.h"

namespace ertbench {

class JsonObject;

/// A ball: on a foam of stiffness k = modulus / thickness a force F gives the contact radius a with
/// F = pi k a^4 / 4R and the pressure k (a^2 - r^2) / 2R.
struct Sphere {
  double radius_mm = 15;  ///< assumed

  bool operator==(const Sphere&) const = default;
};

/// A stiff body with a flat face: the same pressure F / area everywhere on it. A disc, an ellipse
/// (a fingertip) or a polygon.
struct FlatFace {
  Eigen::Vector2d semi_axes_mm = {10, 10};   ///< unused for a polygon
  double angle = 0;                          ///< of the first axis against x, rad
  std::vector<Eigen::Vector2d> vertices_mm;  ///< of a polygon, around its centre (0, 0)

  bool operator==(const FlatFace&) const = default;
};

/// What presses on the skin, around its own centre.
struct Indenter {
  std::variant<FlatFace, Sphere> body;

  bool operator==(const Indenter&) const = default;

  /// For people: "ball of radius 15 mm", "disc of radius 10 mm", "ellipse of 8 x 10 mm".
  std::string text() const;
};

/// Reads `{"type": "sphere", "radius_mm"}`, `{"type": "flat", "radius_mm"}`, `{"type": "flat",
/// "vertices_mm"}` or `{"type": "finger", "semi_axes_mm": [8, 10], "angle"}`; every key but the
/// type and the vertices is optional.
Indenter indenter_from_json(JsonObject object);
nlohmann::json to_json(const Indenter& indenter);

/// An indenter pressed on the skin.
struct Touch {
  Indenter indenter;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< from the sheet's centre
  double force_N = 0;
};

/// Where the touch has pressure, in mm: a disc, an ellipse or a polygon. The touch must have a
/// force.
Contact footprint_mm(const Touch& touch, const Foam& foam);

/// Mean pressure on an axis-parallel box, kPa, once the foam has relaxed. Pressure integrated over
/// boxes that cover the footprint is the force: 1 N is 1000 kPa mm^2.
double mean_pressure_kPa(const Touch& touch, const Foam& foam, const Eigen::AlignedBox2d& box_mm);

}  // namespace ertbench
