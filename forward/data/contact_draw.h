#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "forward/sheet/scene.h"

namespace ertbench {

/// What may be drawn: a contact's shape, or a figure made of one. A ring is a disc with a hole of
/// .55 of its radius, a cross two bars across each other, a bar a rectangle of aspect .12.
enum class DrawnShape { disc, ellipse, rectangle, polygon, ring, cross, bar };

const char* name_of(DrawnShape shape);
/// In the order of the enumeration.
const std::vector<std::string>& names_of_drawn_shapes();
DrawnShape drawn_shape_named(const std::string& name);  ///< one of these names

/// The random quantities that one contact of a SceneDistribution is made of, each independent of
/// the others and uniform in an interval of its own. All are there for every shape, whichever of
/// them it looks at.
struct ContactDraw {
  DrawnShape shape = DrawnShape::disc;
  double size = 0;  ///< radius of the circle around the contact, domain units
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of that circle
  double conductivity_ratio = 1;
  double aspect = 1;  ///< shorter axis or side over longer
  double angle = 0;   ///< rad, 0 ... pi

  /// Of a polygon, which has one corner in each of as many equal sectors.
  struct Corner {
    double turn = 0;   ///< from the sector's middle, sectors, -corner_turn ... corner_turn
    double reach = 1;  ///< 0: at `aspect` of the size from the centre, 1: on the circle
  };
  std::vector<Corner> corners;
};

inline constexpr double corner_turn = 0.25;
inline constexpr int ring_vertices = 62;  ///< of the polygon that a ring is

Contact contact_of(const ContactDraw& drawn);

}  // namespace ertbench
