#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/random.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// Shapes of drawn contacts. A ring is a disc with a hole of .55 of its radius, a bar a rectangle
/// of aspect .12, a cross two bars.
enum class DrawnShape { disc, ellipse, rectangle, polygon, ring, cross, bar };

const char* name_of(DrawnShape shape);
/// In the order of the enumeration.
const std::vector<std::string>& names_of_drawn_shapes();
DrawnShape drawn_shape_named(const std::string& name);  ///< one of these names

/// The random quantities of one contact of a SceneDistribution, independent and uniform, each in
/// its own interval. All are drawn for every shape, whether it uses them or not.
struct ContactDraw {
  DrawnShape shape = DrawnShape::disc;
  double size = 0;  ///< radius of the circle around the contact, domain units
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of that circle
  double conductivity_ratio = 1;
  double aspect = 1;  ///< shorter axis or side over longer
  double angle = 0;   ///< rad, 0 ... pi

  /// A corner of a polygon, which has one corner in each of n equal sectors.
  struct Corner {
    double turn = 0;   ///< from the middle of its sector, in sectors, -corner_turn ... corner_turn
    double reach = 1;  ///< 0: at `aspect` of the size from the centre, 1: on the circle
  };
  std::vector<Corner> corners;
};

inline constexpr double corner_turn = 0.25;
inline constexpr int ring_vertices = 62;  ///< a ring is a polygon

Contact contact_of(const ContactDraw& drawn);

class JsonObject;

/// Random scenes. Every quantity is drawn uniformly and independently from its interval.
struct SceneDistribution {
  std::pair<int, int> contacts = {1, 3};  ///< contacts in a scene
  std::vector<DrawnShape> shapes = {DrawnShape::disc, DrawnShape::ellipse, DrawnShape::rectangle,
                                    DrawnShape::polygon};
  std::pair<double, double> radius = {0.06, 0.4};  ///< of the circle around the contact
  std::pair<double, double> aspect = {0.4, 1};     ///< shorter axis or side over longer
  std::pair<int, int> corners = {3, 8};            ///< of a polygon
  std::pair<double, double> conductivity_ratio = {0.1, 0.9};
  double blank_fraction = 0;  ///< share of scenes without a contact
  bool inside = true;  ///< the circle around each contact lies in the sheet, else only its centre
  /// Intervals of the centres' x and y, domain units. If given, `inside` is ignored.
  std::optional<std::pair<std::pair<double, double>, std::pair<double, double>>> centre;
  /// Gap between the circles around two contacts, in a random direction, both inside the sheet.
  /// Only for scenes with two contacts.
  std::optional<std::pair<double, double>> gap;

  /// Uses the same random numbers for all intervals, so that scenes of two distributions that
  /// differ in one interval are paired.
  Scene draw(RandomStream& random, const Sheet& sheet) const;
  /// The contacts, drawn independently, before `gap` moves them.
  std::vector<ContactDraw> draw_contacts(RandomStream& random, const Sheet& sheet) const;
  ContactDraw draw_contact(RandomStream& random, const Sheet& sheet) const;
  std::size_t most_vertices() const;  ///< of one contact, 0 without polygons
};

/// Reads `{"contacts", "shapes", "radius", "aspect", "corners", "conductivity_ratio",
/// "blank_fraction", "placement", "centre": {"x", "y"}, "gap"}`; an interval is [low, high] or one
/// number. Lengths and positions may be given in millimetres: `radius_mm`, `x_mm`, ...
/// (SheetLengths).
SceneDistribution scene_distribution_from_json(JsonObject object, const Sheet& sheet);
nlohmann::json to_json(const SceneDistribution& distribution);

}  // namespace ertbench
