#include "forward/sheet/scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/fields.h"
#include "core/json.h"
#include "forward/sheet/cross.h"
#include "forward/sheet/sensor_json.h"

namespace ertbench {
namespace {

const std::vector<std::string> shape_names = {"disc", "ellipse", "rectangle", "polygon"};

bool segments_cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                    const Eigen::Vector2d& d) {
  const auto side = [](const auto& p, const auto& q, const auto& r) { return cross(q - p, r - p); };
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

bool crosses_itself(const std::vector<Eigen::Vector2d>& vertices) {
  const std::size_t n = vertices.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      if (segments_cross(vertices[i], vertices[(i + 1) % n], vertices[j], vertices[(j + 1) % n])) {
        return true;
      }
    }
  }
  return false;
}

Contact contact_from_json(JsonObject object, const Sheet& sheet) {
  const Range position{-100, 100};
  const Range length{contact_lengths[0], contact_lengths[1]};
  SheetLengths lengths(object, sheet);
  Contact contact;
  contact.shape = shape_named(object.choice("shape", shape_names));
  if (contact.shape == Shape::polygon) {
    contact.vertices = lengths.places("vertices", 3, 64, position);
    if (crosses_itself(contact.vertices)) lengths.fail("vertices", "must not cross themselves");
  } else {
    contact.centre = lengths.place("centre", position);
    if (contact.shape == Shape::disc) {
      contact.half_size.setConstant(lengths.length("radius", length));
    } else {
      contact.half_size =
          lengths.lengths(contact.shape == Shape::ellipse ? "semi_axes" : "half_sides", length);
      contact.angle = object.number_or("angle", 0, {-1000, 1000});
    }
  }
  contact.conductivity_ratio =
      object.number("conductivity_ratio", {conductivity_ratios[0], conductivity_ratios[1]});
  object.finish();
  return contact;
}

void visit(Fields& fields, Foam& foam) {
  fields.number("thickness_mm", foam.thickness_mm, {0.01, 1000, false, "mm"});
  fields.number("modulus_MPa", foam.modulus_MPa, {1e-6, 1e6, false, "MPa"});
  fields.number("prompt_share", foam.prompt_share, {0, 1});
  fields.number("relaxation_s", foam.relaxation_s, {0, 1e6, false, "s"});
}

void visit(Fields& fields, ContactLaw& law) {
  constexpr Range pressure{1e-6, 1e9, false, "kPa"};
  bool falls = std::holds_alternative<FallingLaw>(law);
  fields.required().choice("type", falls, {{"falling", true}, {"rising", false}});
  FallingLaw falling = falls && !fields.reading() ? std::get<FallingLaw>(law) : FallingLaw{};
  RisingLaw rising = falls || fields.reading() ? RisingLaw{} : std::get<RisingLaw>(law);
  if (falls || fields.describing()) {
    fields.number("depth", falling.depth, {0, 0.999, true});
    fields.number("half_pressure_kPa", falling.half_pressure_kPa, pressure);
  }
  if (!falls || fields.describing()) {
    fields.number("reference_pressure_kPa", rising.reference_pressure_kPa, pressure);
    fields.number("reference_ratio", rising.reference_ratio, {1, 1000, true});
  }
  law = falls ? ContactLaw(falling) : ContactLaw(rising);
}

/// `side_mm`: of the sheet.
void visit(Fields& fields, Skin& skin, double side_mm) {
  fields.integer("patches", skin.patches, 1, 96);
  const double pitch = side_mm / skin.patches;
  if (fields.reading()) skin.patch_mm = 0.9 * pitch;
  fields.derived().number("patch_mm", skin.patch_mm, {0, pitch * (1 + 1e-9), true, "mm"});
  fields.object("foam", [&](Fields& foam) { visit(foam, skin.foam); });
  fields.object("law", [&](Fields& law) { visit(law, skin.law); });
}

}  // namespace

Shape shape_named(const std::string& name) {
  return static_cast<Shape>(std::find(shape_names.begin(), shape_names.end(), name) -
                            shape_names.begin());
}

const char* name_of(Shape shape) { return shape_names[static_cast<std::size_t>(shape)].c_str(); }

Eigen::AlignedBox2d Contact::bounds() const {
  if (shape == Shape::polygon) {
    Eigen::AlignedBox2d box;
    for (const auto& vertex : vertices) box.extend(vertex);
    return box;
  }
  const Eigen::Vector2d first = half_size.x() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d second = half_size.y() * Eigen::Vector2d(-std::sin(angle), std::cos(angle));
  const Eigen::Vector2d reach =
      shape == Shape::rectangle
          ? Eigen::Vector2d(first.cwiseAbs() + second.cwiseAbs())
          : Eigen::Vector2d((first.cwiseAbs2() + second.cwiseAbs2()).cwiseSqrt());
  return {centre - reach, centre + reach};
}

bool Contact::contains(const Eigen::Vector2d& point) const {
  if (shape == Shape::polygon) {
    bool inside = false;
    for (std::size_t i = 0, j = vertices.size() - 1; i < vertices.size(); j = i++) {
      const Eigen::Vector2d& a = vertices[i];
      const Eigen::Vector2d& b = vertices[j];
      if ((a.y() > point.y()) != (b.y() > point.y()) &&
          point.x() < (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y()) + a.x()) {
        inside = !inside;
      }
    }
    return inside;
  }
  const Eigen::Vector2d d = point - centre;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double along = (c * d.x() + s * d.y()) / half_size.x();
  const double across = (c * d.y() - s * d.x()) / half_size.y();
  return shape == Shape::rectangle ? std::max(std::abs(along), std::abs(across)) <= 1
                                   : along * along + across * across <= 1;
}

Eigen::Vector2d Contact::centroid() const {
  if (shape != Shape::polygon) return centre;
  const Eigen::Vector2d& origin = vertices.front();
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  double area = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector2d a = vertices[i] - origin;
    const Eigen::Vector2d b = vertices[(i + 1) % vertices.size()] - origin;
    moment += cross(a, b) * (a + b) / 3;
    area += cross(a, b);
  }
  return area == 0 ? origin : Eigen::Vector2d(origin + moment / area);
}

Scene scene_from_json(JsonObject object, const Sheet& sheet) {
  Scene scene;
  for (const JsonObject& contact : object.objects("contacts")) {
    scene.contacts.push_back(contact_from_json(contact, sheet));
  }
  object.finish();
  return scene;
}

nlohmann::json to_json(const Scene& scene) {
  nlohmann::json contacts = nlohmann::json::array();
  const auto pair = [](const Eigen::Vector2d& v) { return nlohmann::json{v.x(), v.y()}; };
  for (const Contact& contact : scene.contacts) {
    nlohmann::json object = {{"shape", name_of(contact.shape)},
                             {"conductivity_ratio", contact.conductivity_ratio}};
    if (contact.shape == Shape::polygon) {
      for (const auto& vertex : contact.vertices) object["vertices"].push_back(pair(vertex));
    } else {
      object["centre"] = pair(contact.centre);
      if (contact.shape == Shape::disc) {
        object["radius"] = contact.half_size.x();
      } else {
        object[contact.shape == Shape::ellipse ? "semi_axes" : "half_sides"] =
            pair(contact.half_size);
        object["angle"] = contact.angle;
      }
    }
    contacts.push_back(std::move(object));
  }
  return {{"contacts", std::move(contacts)}};
}

const char* name_of(const ContactLaw& law) {
  return std::holds_alternative<FallingLaw>(law) ? "falling" : "rising";
}

Skin skin_from_json(JsonObject object, double side_mm) {
  Skin skin;
  Fields::read(std::move(object), [&](Fields& fields) { visit(fields, skin, side_mm); });
  return skin;
}

nlohmann::json to_json(const Skin& skin) {
  Skin copy = skin;
  return Fields::written([&](Fields& fields) { visit(fields, copy, 0); });
}

nlohmann::ordered_json skin_schema() {
  Skin skin;
  return Fields::schema([&](Fields& fields) { visit(fields, skin, INFINITY); });
}

}  // namespace ertbench
