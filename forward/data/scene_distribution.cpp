#include "forward/data/scene_distribution.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/json.h"
#include "forward/sheet/sensor_json.h"

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

constexpr double rounding = 1e-12;  ///< of lengths, domain units

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

std::size_t SceneDistribution::most_vertices() const {
  std::size_t most = 0;
  for (const DrawnShape shape : shapes) {
    if (shape == DrawnShape::ring) most = std::max<std::size_t>(most, ring_vertices);
    if (shape == DrawnShape::cross) most = std::max<std::size_t>(most, 12);
    if (shape == DrawnShape::polygon) {
      most = std::max(most, static_cast<std::size_t>(corners.second));
    }
  }
  return most;
}

ContactDraw SceneDistribution::draw_contact(RandomStream& random, const Sheet& sheet) const {
  ContactDraw drawn;
  drawn.shape =
      shapes[static_cast<std::size_t>(random.integer(0, static_cast<int>(shapes.size()) - 1))];
  drawn.size = random.uniform(radius.first, radius.second);
  if (centre) {
    const double x = random.uniform(centre->first.first, centre->first.second);
    const double y = random.uniform(centre->second.first, centre->second.second);
    drawn.centre = {x, y};
  } else {
    drawn.centre = place_on(sheet, inside ? drawn.size : 0, random);
  }
  drawn.conductivity_ratio = random.uniform(conductivity_ratio.first, conductivity_ratio.second);
  drawn.aspect = random.uniform(aspect.first, aspect.second);
  drawn.angle = random.uniform(0, pi);
  if (drawn.shape == DrawnShape::polygon) {
    drawn.corners.resize(static_cast<std::size_t>(random.integer(corners.first, corners.second)));
    for (ContactDraw::Corner& corner : drawn.corners) {
      corner.turn = random.uniform(-corner_turn, corner_turn);
      corner.reach = random.uniform();
    }
  }
  return drawn;
}

std::vector<ContactDraw> SceneDistribution::draw_contacts(RandomStream& random,
                                                          const Sheet& sheet) const {
  std::vector<ContactDraw> drawn;
  if (random.uniform() < blank_fraction) return drawn;
  const int count = random.integer(contacts.first, contacts.second);
  for (int c = 0; c < count; ++c) drawn.push_back(draw_contact(random, sheet));
  return drawn;
}

Scene SceneDistribution::draw(RandomStream& random, const Sheet& sheet) const {
  Scene scene;
  const std::vector<ContactDraw> drawn = draw_contacts(random, sheet);
  for (const ContactDraw& contact : drawn) scene.contacts.push_back(contact_of(contact));
  if (gap && drawn.size() == 2) {
    const double direction = random.uniform(0, 2 * pi);
    const double distance = drawn[0].size + drawn[1].size + random.uniform(gap->first, gap->second);
    set_apart(scene.contacts[0], drawn[0].size, scene.contacts[1], drawn[1].size,
              distance * Eigen::Vector2d(std::cos(direction), std::sin(direction)), sheet);
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
    for (const std::string& name : object.choices("shapes", names_of_drawn_shapes())) {
      d.shapes.push_back(drawn_shape_named(name));
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
  nlohmann::json json = {{"contacts", d.contacts},
                         {"shapes", shapes},
                         {"radius", d.radius},
                         {"aspect", d.aspect},
                         {"corners", d.corners},
                         {"conductivity_ratio", d.conductivity_ratio},
                         {"blank_fraction", d.blank_fraction},
                         {"placement", d.inside ? "inside" : "centre-inside"}};
  if (d.centre) json["centre"] = {{"x", d.centre->first}, {"y", d.centre->second}};
  if (d.gap) json["gap"] = *d.gap;
  return json;
}

}  // namespace ertbench
