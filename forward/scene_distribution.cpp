#include "forward/scene_distribution.h"

#include <nlohmann/json.hpp>
#include <numbers>

#include "forward/json_reader.h"

namespace ertbench {

using std::numbers::pi;

Scene SceneDistribution::draw(RandomStream& random) const {
  Scene scene;
  if (random.uniform() < blank_fraction) return scene;
  const int count = random.integer(contacts.first, contacts.second);
  for (int c = 0; c < count; ++c) {
    Contact contact;
    contact.shape =
        shapes[static_cast<std::size_t>(random.integer(0, static_cast<int>(shapes.size()) - 1))];
    const double size = random.uniform(radius.first, radius.second);
    const double room = inside ? 1 - size : 1;
    const double x = random.uniform(-room, room);
    const double y = random.uniform(-room, room);
    contact.centre = {x, y};
    contact.conductivity_ratio =
        random.uniform(conductivity_ratio.first, conductivity_ratio.second);
    const double shape_ratio = random.uniform(aspect.first, aspect.second);
    contact.angle = random.uniform(0, pi);
    switch (contact.shape) {
      case Shape::disc:
        contact.half_size.setConstant(size);
        contact.angle = 0;
        break;
      case Shape::ellipse:
        contact.half_size = {size, size * shape_ratio};
        break;
      case Shape::rectangle:  // its corners lie on the circle
        contact.half_size = Eigen::Vector2d(1, shape_ratio).normalized() * size;
        break;
      case Shape::polygon: {
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
    scene.contacts.push_back(std::move(contact));
  }
  return scene;
}

SceneDistribution scene_distribution_from_json(JsonObject object) {
  SceneDistribution d;
  if (object.has("contacts")) d.contacts = object.integer_interval("contacts", 0, 64);
  if (object.has("shapes")) {
    d.shapes.clear();
    for (const std::string& name :
         object.choices("shapes", {"disc", "ellipse", "rectangle", "polygon"})) {
      d.shapes.push_back(shape_named(name));
    }
  }
  if (object.has("radius")) d.radius = object.interval("radius", {0, 2, true});
  if (object.has("aspect")) d.aspect = object.interval("aspect", {0, 1, true});
  if (object.has("corners")) d.corners = object.integer_interval("corners", 3, 64);
  if (object.has("conductivity_ratio")) {
    d.conductivity_ratio = object.interval("conductivity_ratio", {0, 1000, true});
  }
  d.blank_fraction = object.number_or("blank_fraction", 0, {0, 1});
  d.inside = object.choice_or("placement", "inside", {"inside", "centre-inside"}) == "inside";
  if (d.inside && d.radius.second > 1) {
    object.fail("radius", R"(must be <= 1 for contacts placed "inside" the sheet)");
  }
  object.finish();
  return d;
}

nlohmann::json to_json(const SceneDistribution& d) {
  nlohmann::json shapes = nlohmann::json::array();
  for (const Shape shape : d.shapes) shapes.push_back(name_of(shape));
  return {{"contacts", {d.contacts.first, d.contacts.second}},
          {"shapes", shapes},
          {"radius", {d.radius.first, d.radius.second}},
          {"aspect", {d.aspect.first, d.aspect.second}},
          {"corners", {d.corners.first, d.corners.second}},
          {"conductivity_ratio", {d.conductivity_ratio.first, d.conductivity_ratio.second}},
          {"blank_fraction", d.blank_fraction},
          {"placement", d.inside ? "inside" : "centre-inside"}};
}

}  // namespace ertbench
