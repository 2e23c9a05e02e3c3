#include "forward/data/contact_draw.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {

using std::numbers::pi;

namespace {

constexpr double bar_aspect = 0.12;
constexpr double ring_hole = 0.55;                   ///< inner over outer radius
constexpr int ring_corners = ring_vertices / 2 - 1;  ///< of each of its two borders
constexpr double cross_arm = 0.35;                   ///< breadth over length of its bars

Shape shape_of(DrawnShape drawn) {
  switch (drawn) {
    case DrawnShape::disc:
      return Shape::disc;
    case DrawnShape::ellipse:
      return Shape::ellipse;
    case DrawnShape::rectangle:
    case DrawnShape::bar:
      return Shape::rectangle;
    default:
      return Shape::polygon;
  }
}

Eigen::Vector2d at_angle(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Around (0, 0), one polygon: out along its outer border, across a seam of no breadth, and back
/// along the inner one.
std::vector<Eigen::Vector2d> ring(double radius) {
  std::vector<Eigen::Vector2d> vertices;
  for (int v = 0; v <= ring_corners; ++v) {
    vertices.push_back(radius * at_angle(2 * pi * (v % ring_corners) / ring_corners));
  }
  for (int v = ring_corners; v >= 0; --v) {
    vertices.push_back(ring_hole * vertices[static_cast<std::size_t>(v)]);
  }
  return vertices;
}

/// Around (0, 0), its corners on the circle of `radius`.
std::vector<Eigen::Vector2d> cross(double radius, double angle) {
  const Eigen::Vector2d tip = Eigen::Vector2d(1, cross_arm).normalized() * radius;
  std::vector<Eigen::Vector2d> vertices;
  for (int arm = 0; arm < 4; ++arm) {
    const Eigen::Vector2d along = at_angle(angle + pi / 2 * arm);
    const Eigen::Vector2d across(-along.y(), along.x());
    vertices.push_back(tip.x() * along - tip.y() * across);
    vertices.push_back(tip.x() * along + tip.y() * across);
    vertices.push_back(tip.y() * along + tip.y() * across);
  }
  return vertices;
}

}  // namespace

const std::vector<std::string>& names_of_drawn_shapes() {
  static const std::vector<std::string> names = {"disc", "ellipse", "rectangle", "polygon",
                                                 "ring", "cross",   "bar"};
  return names;
}

const char* name_of(DrawnShape shape) {
  return names_of_drawn_shapes()[static_cast<std::size_t>(shape)].c_str();
}

DrawnShape drawn_shape_named(const std::string& name) {
  const std::vector<std::string>& names = names_of_drawn_shapes();
  return static_cast<DrawnShape>(std::find(names.begin(), names.end(), name) - names.begin());
}

Contact contact_of(const ContactDraw& drawn) {
  Contact contact;
  contact.shape = shape_of(drawn.shape);
  contact.centre = drawn.centre;
  contact.conductivity_ratio = drawn.conductivity_ratio;
  contact.angle = drawn.angle;
  switch (drawn.shape) {
    case DrawnShape::disc:
      contact.half_size.setConstant(drawn.size);
      contact.angle = 0;
      break;
    case DrawnShape::ellipse:
      contact.half_size = {drawn.size, drawn.size * drawn.aspect};
      break;
    case DrawnShape::rectangle:  // its corners lie on the circle
      contact.half_size = Eigen::Vector2d(1, drawn.aspect).normalized() * drawn.size;
      break;
    case DrawnShape::bar:
      contact.half_size = Eigen::Vector2d(1, bar_aspect).normalized() * drawn.size;
      break;
    case DrawnShape::ring:
    case DrawnShape::cross:
      contact.vertices =
          drawn.shape == DrawnShape::ring ? ring(drawn.size) : cross(drawn.size, drawn.angle);
      for (Eigen::Vector2d& vertex : contact.vertices) vertex += contact.centre;
      contact.angle = 0;
      break;
    case DrawnShape::polygon: {
      // Star-shaped, hence not self-crossing: one corner in each equal sector, the aspect setting
      // how far it may move in towards the centre.
      const auto n = static_cast<double>(drawn.corners.size());
      for (std::size_t v = 0; v < drawn.corners.size(); ++v) {
        const ContactDraw::Corner& corner = drawn.corners[v];
        const double direction =
            contact.angle + 2 * pi * (static_cast<double>(v) + corner.turn) / n;
        const double distance = drawn.size * (drawn.aspect + (1 - drawn.aspect) * corner.reach);
        contact.vertices.push_back(contact.centre + distance * at_angle(direction));
      }
      contact.angle = 0;
      break;
    }
  }
  return contact;
}

}  // namespace ertbench
