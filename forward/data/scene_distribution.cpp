#include "forward/data/scene_distribution.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/json_reader.h"
#include "forward/sheet/sheet_lengths.h"

namespace ertbench {

using std::numbers::pi;

namespace {

const std::vector<std::string> shape_names = {"disc", "ellipse", "rectangle", "polygon",
                                              "ring", "cross",   "bar"};
constexpr double bar_aspect = 0.12;
constexpr double ring_hole = 0.55;  ///< inner over outer radius
constexpr int ring_corners = 30;    ///< of each of its two borders
constexpr double cross_arm = 0.35;  ///< breadth over length of its bars
constexpr double rounding = 1e-12;  ///< of lengths, domain units

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

void move(Contact& contact, const Eigen::Vector2d& by) {
  contact.centre += by;
  for (Eigen::Vector2d& vertex : contact.vertices) vertex += by;
}

/// A place at random, uniform over the part of the sheet that is at least `margin` from its border.
Eigen::Vector2d place_on(const Sheet& sheet, double margin, RandomStream& random) {
  const Eigen::Vector2d low = sheet.bounds().min().array() + margin;
  const Eigen::Vector2d high = sheet.bounds().max().array() - margin;
  for (;;) {
    const double x = random.uniform(low.x(), high.x());
    const double y = random.uniform(low.y(), high.y());
    if (sheet.depth({x, y}) >= margin - rounding) return {x, y};
  }
}

/// Puts the second contact at `distance` between the centres from the first, which is moved no
/// farther than both being in the sheet's bounds demands, and then towards the sheet's middle until
/// both are on the sheet. Radii are those of the circles around them.
void set_apart(Contact& first, double first_radius, Contact& second, double second_radius,
               const Eigen::Vector2d& distance, const Sheet& sheet) {
  const Eigen::Array2d low = sheet.bounds().min();
  const Eigen::Array2d high = sheet.bounds().max();
  Eigen::Vector2d place = first.centre.array()
                              .max(low + second_radius - distance.array())
                              .min(high - second_radius - distance.array())
                              .max(low + first_radius)
                              .min(high - first_radius)
                              .matrix();
  const auto fits = [&](const Eigen::Vector2d& at) {
    return sheet.depth(at) >= first_radius - rounding &&
           sheet.depth(at + distance) >= second_radius - rounding;
  };
  const Eigen::Vector2d from = place;
  const Eigen::Vector2d inmost = sheet.bounds().center() - distance / 2;
  for (int step = 1; step <= 64 && !fits(place); ++step) {
    place = from + step / 64.0 * (inmost - from);
  }
  move(first, place - first.centre);
  move(second, place + distance - second.centre);
}

}  // namespace

const char* name_of(DrawnShape shape) {
  return shape_names[static_cast<std::size_t>(shape)].c_str();
}

std::size_t SceneDistribution::most_vertices() const {
  std::size_t most = 0;
  for (const DrawnShape shape : shapes) {
    if (shape == DrawnShape::ring) most = std::max<std::size_t>(most, 2 * (ring_corners + 1));
    if (shape == DrawnShape::cross) most = std::max<std::size_t>(most, 12);
    if (shape == DrawnShape::polygon) {
      most = std::max(most, static_cast<std::size_t>(corners.second));
    }
  }
  return most;
}

Scene SceneDistribution::draw(RandomStream& random, const Sheet& sheet) const {
  Scene scene;
  if (random.uniform() < blank_fraction) return scene;
  const int count = random.integer(contacts.first, contacts.second);
  std::vector<double> radii;
  for (int c = 0; c < count; ++c) {
    Contact contact;
    const DrawnShape drawn =
        shapes[static_cast<std::size_t>(random.integer(0, static_cast<int>(shapes.size()) - 1))];
    contact.shape = shape_of(drawn);
    const double size = random.uniform(radius.first, radius.second);
    if (centre) {
      const double x = random.uniform(centre->first.first, centre->first.second);
      const double y = random.uniform(centre->second.first, centre->second.second);
      contact.centre = {x, y};
    } else {
      contact.centre = place_on(sheet, inside ? size : 0, random);
    }
    contact.conductivity_ratio =
        random.uniform(conductivity_ratio.first, conductivity_ratio.second);
    const double shape_ratio = random.uniform(aspect.first, aspect.second);
    contact.angle = random.uniform(0, pi);
    switch (drawn) {
      case DrawnShape::disc:
        contact.half_size.setConstant(size);
        contact.angle = 0;
        break;
      case DrawnShape::ellipse:
        contact.half_size = {size, size * shape_ratio};
        break;
      case DrawnShape::rectangle:  // its corners lie on the circle
        contact.half_size = Eigen::Vector2d(1, shape_ratio).normalized() * size;
        break;
      case DrawnShape::bar:
        contact.half_size = Eigen::Vector2d(1, bar_aspect).normalized() * size;
        break;
      case DrawnShape::ring:
      case DrawnShape::cross:
        contact.vertices = drawn == DrawnShape::ring ? ring(size) : cross(size, contact.angle);
        for (Eigen::Vector2d& vertex : contact.vertices) vertex += contact.centre;
        contact.angle = 0;
        break;
      case DrawnShape::polygon: {
        // Star-shaped, hence not self-crossing: one corner in each equal sector, the aspect
        // setting how far it may move in towards the centre.
        const int n = random.integer(corners.first, corners.second);
        for (int v = 0; v < n; ++v) {
          const double direction = contact.angle + 2 * pi * (v + random.uniform(-0.25, 0.25)) / n;
          const double distance = size * random.uniform(shape_ratio, 1);
          contact.vertices.push_back(contact.centre +
                                     distance *
                                         Eigen::Vector2d(std::cos(direction), std::sin(direction)));
        }
        contact.angle = 0;
        break;
      }
    }
    radii.push_back(size);
    scene.contacts.push_back(std::move(contact));
  }
  if (gap && count == 2) {
    const double direction = random.uniform(0, 2 * pi);
    const double distance = radii[0] + radii[1] + random.uniform(gap->first, gap->second);
    set_apart(scene.contacts[0], radii[0], scene.contacts[1], radii[1],
              distance * at_angle(direction), sheet);
  }
  return scene;
}

SceneDistribution scene_distribution_from_json(JsonObject object, const Sheet& sheet) {
  const Eigen::AlignedBox2d& bounds = sheet.bounds();
  const double room = sheet.inner_radius();
  SheetLengths lengths(object, sheet);
  SceneDistribution d;
  if (object.has("contacts")) d.contacts = object.integer_interval("contacts", 0, 64);
  if (object.has("shapes")) {
    d.shapes.clear();
    for (const std::string& name : object.choices("shapes", shape_names)) {
      d.shapes.push_back(static_cast<DrawnShape>(
          std::find(shape_names.begin(), shape_names.end(), name) - shape_names.begin()));
    }
  }
  if (lengths.has("radius")) {
    d.radius = lengths.length_interval("radius", {contact_lengths[0], 2});
  }
  if (object.has("aspect")) d.aspect = object.interval("aspect", {1e-3, 1});
  if (object.has("corners")) d.corners = object.integer_interval("corners", 3, 64);
  if (object.has("conductivity_ratio")) {
    d.conductivity_ratio =
        object.interval("conductivity_ratio", {conductivity_ratios[0], conductivity_ratios[1]});
  }
  d.blank_fraction = object.number_or("blank_fraction", 0, {0, 1});
  d.inside = object.choice_or("placement", "inside", {"inside", "centre-inside"}) == "inside";
  if (object.has("centre")) {
    JsonObject centre = object.object("centre");
    SheetLengths places(centre, sheet);
    d.centre.emplace(places.coordinate_interval("x", 0, {bounds.min().x(), bounds.max().x()}),
                     places.coordinate_interval("y", 1, {bounds.min().y(), bounds.max().y()}));
    centre.finish();
  }
  if (lengths.has("gap")) {
    d.gap = lengths.length_interval("gap", {0, 2});
    if (d.contacts != std::pair(2, 2)) lengths.fail("gap", R"(needs "contacts": 2)");
    if (d.centre || !d.inside) lengths.fail("gap", R"(places contacts "inside" the sheet itself)");
    if (4 * d.radius.second + d.gap->second > 2 * room) {
      lengths.fail("gap", "must leave room for both contacts: gap + 4 radius <= " +
                              lengths.shown("gap", 2 * room));
    }
  }
  if (d.inside && !d.centre && d.radius.second > room) {
    lengths.fail("radius", "must be <= " + lengths.shown("radius", room) +
                               R"( for contacts placed "inside" the sheet)");
  }
  object.finish();
  return d;
}

nlohmann::json to_json(const SceneDistribution& d) {
  nlohmann::json shapes = nlohmann::json::array();
  for (const DrawnShape shape : d.shapes) shapes.push_back(name_of(shape));
  nlohmann::json json = {
      {"contacts", {d.contacts.first, d.contacts.second}},
      {"shapes", shapes},
      {"radius", {d.radius.first, d.radius.second}},
      {"aspect", {d.aspect.first, d.aspect.second}},
      {"corners", {d.corners.first, d.corners.second}},
      {"conductivity_ratio", {d.conductivity_ratio.first, d.conductivity_ratio.second}},
      {"blank_fraction", d.blank_fraction},
      {"placement", d.inside ? "inside" : "centre-inside"}};
  const auto both = [](const auto& interval) {
    return nlohmann::json{interval.first, interval.second};
  };
  if (d.centre) json["centre"] = {{"x", both(d.centre->first)}, {"y", both(d.centre->second)}};
  if (d.gap) json["gap"] = both(*d.gap);
  return json;
}

}  // namespace ertbench
