#include "forward/touch/indenter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/json.h"
#include "core/text.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using std::numbers::pi;

/// x / tanh x as a function of x^2, smooth at 0.
double shunt(double square) {
  if (square < 1e-4) return 1 + square / 3 - square * square / 45;
  const double x = std::sqrt(square);
  return x / std::tanh(x);
}

/// The pressure at which x = 1: x^2 = p / unit.
double unit_pressure(const RisingLaw& law) {
  // x / tanh x = ratio by x <- ratio tanh x, which contracts for every ratio > 1.
  double x = law.reference_ratio;
  double last = 0;
  for (int i = 0; i < 200 && x != last; ++i)
    last = std::exchange(x, law.reference_ratio * std::tanh(x));
  return law.reference_pressure_kPa / (x * x);
}

constexpr double kPa_of_MPa = 1000;

/// MPa/mm.
double stiffness(const Foam& foam) { return foam.modulus_MPa / foam.thickness_mm; }

double contact_radius_mm(const Sphere& ball, double force_N, const Foam& foam) {
  return std::pow(4 * ball.radius_mm * force_N / (pi * stiffness(foam)), 0.25);
}

double area_mm2(const FlatFace& face) {
  if (face.vertices_mm.empty()) return pi * face.semi_axes_mm.prod();
  double twice = 0;
  for (std::size_t i = 0; i < face.vertices_mm.size(); ++i) {
    const Vector2d& a = face.vertices_mm[i];
    const Vector2d& b = face.vertices_mm[(i + 1) % face.vertices_mm.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

/// Integral of 1 - x^2 - y^2 over the part of the unit disc in the box. Lines across are integrated
/// in closed form; with y = sin t what is left is smooth between the heights at which the circle
/// passes the box's upright sides, where Gauss's rule is exact to rounding.
double paraboloid_integral(const Eigen::AlignedBox2d& box) {
  static constexpr std::array<double, 6> nodes = {0.1252334085114689, 0.3678314989981802,
                                                  0.5873179542866175, 0.7699026741943047,
                                                  0.9041172563704749, 0.9815606342467192};
  static constexpr std::array<double, 6> weights = {0.2491470458134028, 0.2334925365383548,
                                                    0.2031674267230659, 0.1600783285433462,
                                                    0.1069393259953184, 0.0471753363865118};
  const double low = std::clamp(box.min().y(), -1.0, 1.0);
  const double high = std::clamp(box.max().y(), -1.0, 1.0);
  const double left = box.min().x();
  const double right = box.max().x();
  if (high <= low || left >= 1 || right <= -1) return 0;
  std::vector<double> cuts = {std::asin(low), std::asin(high)};
  for (const double x : {left, right}) {
    if (std::abs(x) >= 1) continue;
    for (const double y : {-std::sqrt(1 - x * x), std::sqrt(1 - x * x)}) {
      if (y > low && y < high) cuts.push_back(std::asin(y));
    }
  }
  std::sort(cuts.begin(), cuts.end());
  const auto along = [&](double t) {
    const double half = std::cos(t);  // of the chord; also 1 - y^2 = half^2
    const double from = std::max(left, -half);
    const double to = std::min(right, half);
    if (to <= from) return 0.0;
    return half * (half * half * (to - from) - (to * to * to - from * from * from) / 3);
  };
  double sum = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double middle = (cuts[i] + cuts[i + 1]) / 2;
    const double reach = (cuts[i + 1] - cuts[i]) / 2;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      sum += reach * weights[n] *
             (along(middle - reach * nodes[n]) + along(middle + reach * nodes[n]));
    }
  }
  return sum;
}

/// The patches of a skin as boxes, in mm from the sheet's centre.
class Patches {
 public:
  Patches(const Skin& skin, double side_mm)
      : count_(skin.patches),
        pitch_(side_mm / skin.patches),
        half_(skin.patch_mm / 2),
        low_(-side_mm / 2) {}

  double width() const { return 2 * half_ / pitch_; }

  Eigen::AlignedBox2d box(int column, int row) const {
    const Vector2d centre(low_ + (column + 0.5) * pitch_, low_ + (row + 0.5) * pitch_);
    return {centre.array() - half_, centre.array() + half_};
  }

  /// Calls `use(index, box)` for the patches that may touch the box.
  template <typename Use>
  void near(const Eigen::AlignedBox2d& box, const Use& use) const {
    const auto index = [&](double mm) {
      return static_cast<int>(
          std::floor(std::clamp((mm - low_) / pitch_, -1.0, static_cast<double>(count_))));
    };
    const int left = std::max(0, index(box.min().x()));
    const int right = std::min(count_ - 1, index(box.max().x()));
    const int top = std::min(count_ - 1, index(box.max().y()));
    for (int row = std::max(0, index(box.min().y())); row <= top; ++row) {
      for (int column = left; column <= right; ++column) {
        use(column + count_ * row, this->box(column, row));
      }
    }
  }

 private:
  int count_;
  double pitch_;
  double half_;
  double low_;
};

const Skin& skin_of(const Sensor& sensor) {
  if (!sensor.skin) throw std::logic_error("touches need a sensor with a skin");
  return *sensor.skin;
}

double side_mm(const Sensor& sensor) { return sensor.sheet->size_mm().x(); }

/// The footprint in domain units, with the ratio of its most pressed patch.
Contact contact_of(const Sensor& sensor, const Patches& patches, const Touch& touch,
                   const VectorXd& pressure_kPa) {
  const Skin& skin = skin_of(sensor);
  const Vector2d middle = sensor.sheet->bounds().center();
  const double unit = sensor.sheet->unit_mm();
  Contact contact = footprint_mm(touch, skin.foam);
  double most = 0;
  patches.near(contact.bounds(), [&](int patch, const Eigen::AlignedBox2d&) {
    most = std::max(most, pressure_kPa[patch]);
  });
  contact.conductivity_ratio = conductivity_ratio(skin.law, most);
  contact.centre = middle + contact.centre / unit;
  contact.half_size /= unit;
  for (Vector2d& vertex : contact.vertices) vertex = middle + vertex / unit;
  return contact;
}

}  // namespace

double conductivity_ratio(const ContactLaw& law, double kPa) {
  if (const auto* falling = std::get_if<FallingLaw>(&law)) {
    return 1 - falling->depth * kPa / (kPa + falling->half_pressure_kPa);
  }
  return shunt(kPa / unit_pressure(std::get<RisingLaw>(law)));
}

std::string Indenter::text() const {
  if (const auto* ball = std::get_if<Sphere>(&body)) {
    return "ball of radius " + number_text(ball->radius_mm) + " mm";
  }
  const auto& face = std::get<FlatFace>(body);
  if (!face.vertices_mm.empty()) {
    return "polygon of " + std::to_string(face.vertices_mm.size()) + " corners";
  }
  const Vector2d& axes = face.semi_axes_mm;
  if (axes.x() == axes.y()) return "disc of radius " + number_text(axes.x()) + " mm";
  return "ellipse of " + number_text(axes.x()) + " x " + number_text(axes.y()) + " mm";
}

Indenter indenter_from_json(JsonObject object) {
  const Range length{0.1, 1e4, false, "mm"};
  const std::string type = object.choice("type", {"sphere", "flat", "finger"});
  Indenter indenter;
  if (type == "sphere") {
    Sphere ball;
    ball.radius_mm = object.number_or("radius_mm", ball.radius_mm, length);
    indenter.body = ball;
  } else if (type == "finger") {
    FlatFace face;
    face.semi_axes_mm = {8, 10};
    if (object.has("semi_axes_mm")) {
      const std::vector<double> axes = object.numbers("semi_axes_mm", 2, length);
      face.semi_axes_mm = {axes[0], axes[1]};
    }
    face.angle = object.number_or("angle", 0, {-1000, 1000});
    indenter.body = face;
  } else {
    FlatFace face;
    if (object.has("vertices_mm")) {
      for (const auto& [x, y] : object.points("vertices_mm", 3, 64, {-1e4, 1e4, false, "mm"})) {
        face.vertices_mm.emplace_back(x, y);
      }
      if (area_mm2(face) < 1e-3) object.fail("vertices_mm", "must enclose an area");
      if (object.has("radius_mm")) {
        object.fail("radius_mm", R"(is of a disc; leave it out beside "vertices_mm")");
      }
    } else {
      face.semi_axes_mm.setConstant(object.number_or("radius_mm", 10, length));
    }
    indenter.body = face;
  }
  object.finish();
  return indenter;
}

nlohmann::json to_json(const Indenter& indenter) {
  if (const auto* ball = std::get_if<Sphere>(&indenter.body)) {
    return {{"type", "sphere"}, {"radius_mm", ball->radius_mm}};
  }
  const auto& face = std::get<FlatFace>(indenter.body);
  const Vector2d& axes = face.semi_axes_mm;
  if (face.vertices_mm.empty() && axes.x() == axes.y()) {
    return {{"type", "flat"}, {"radius_mm", axes.x()}};
  }
  if (face.vertices_mm.empty()) {
    return {{"type", "finger"}, {"semi_axes_mm", {axes.x(), axes.y()}}, {"angle", face.angle}};
  }
  nlohmann::json json = {{"type", "flat"}};
  for (const Vector2d& v : face.vertices_mm) json["vertices_mm"].push_back({v.x(), v.y()});
  return json;
}

Contact footprint_mm(const Touch& touch, const Foam& foam) {
  Contact contact;
  contact.force_N = touch.force_N;
  if (const auto* ball = std::get_if<Sphere>(&touch.indenter.body)) {
    contact.shape = Shape::disc;
    contact.centre = touch.place_mm;
    contact.half_size.setConstant(contact_radius_mm(*ball, touch.force_N, foam));
    return contact;
  }
  const auto& face = std::get<FlatFace>(touch.indenter.body);
  if (!face.vertices_mm.empty()) {
    contact.shape = Shape::polygon;
    for (const Vector2d& v : face.vertices_mm) contact.vertices.push_back(touch.place_mm + v);
    return contact;
  }
  contact.shape = face.semi_axes_mm.x() == face.semi_axes_mm.y() ? Shape::disc : Shape::ellipse;
  contact.centre = touch.place_mm;
  contact.half_size = face.semi_axes_mm;
  contact.angle = contact.shape == Shape::disc ? 0 : face.angle;
  return contact;
}

double mean_pressure_kPa(const Touch& touch, const Foam& foam, const Eigen::AlignedBox2d& box_mm) {
  if (touch.force_N <= 0) return 0;
  if (const auto* ball = std::get_if<Sphere>(&touch.indenter.body)) {
    const double a = contact_radius_mm(*ball, touch.force_N, foam);
    const Eigen::AlignedBox2d box((box_mm.min() - touch.place_mm) / a,
                                  (box_mm.max() - touch.place_mm) / a);
    const double peak = stiffness(foam) * a * a / (2 * ball->radius_mm) * kPa_of_MPa;
    return peak * paraboloid_integral(box) * a * a / box_mm.volume();
  }
  const double pressure =
      touch.force_N / area_mm2(std::get<FlatFace>(touch.indenter.body)) * kPa_of_MPa;
  return pressure * covered_fraction(footprint_mm(touch, foam), box_mm);
}

VectorXd relaxed_pressure_kPa(const Sensor& sensor, std::span<const Touch> touches) {
  const Skin& skin = skin_of(sensor);
  const Patches patches(skin, side_mm(sensor));
  VectorXd pressure = VectorXd::Zero(skin.patches * skin.patches);
  for (const Touch& touch : touches) {
    if (touch.force_N <= 0) continue;
    patches.near(footprint_mm(touch, skin.foam).bounds(),
                 [&](int patch, const Eigen::AlignedBox2d& box) {
                   pressure[patch] += mean_pressure_kPa(touch, skin.foam, box);
                 });
  }
  return pressure;
}

Scene skin_scene(const Sensor& sensor, std::span<const Touch> touches,
                 const VectorXd& pressure_kPa) {
  const Skin& skin = skin_of(sensor);
  const Patches patches(skin, side_mm(sensor));
  Scene scene;
  for (const Touch& touch : touches) {
    if (touch.force_N <= 0) continue;
    scene.contacts.push_back(contact_of(sensor, patches, touch, pressure_kPa));
  }
  scene.patches = PatchField{skin.patches, patches.width(), VectorXd(pressure_kPa.size())};
  for (Eigen::Index p = 0; p < pressure_kPa.size(); ++p) {
    scene.patches->ratio[p] = conductivity_ratio(skin.law, pressure_kPa[p]);
  }
  return scene;
}

Scene still_scene(const Sensor& sensor, std::span<const Touch> touches) {
  return skin_scene(sensor, touches, relaxed_pressure_kPa(sensor, touches));
}

FoamMemory::FoamMemory(const Foam& foam, VectorXd relaxed_kPa)
    : foam_(foam), relaxed_(std::move(relaxed_kPa)), remembered_(relaxed_) {}

void FoamMemory::advance(double seconds, const VectorXd& relaxed_kPa) {
  const double steps = foam_.relaxation_s > 0 ? seconds / foam_.relaxation_s : 0;
  if (foam_.relaxation_s <= 0) {
    remembered_ = relaxed_kPa;
  } else if (steps > 0) {
    // Exact for a relaxed pressure that is linear in time.
    const double kept = std::exp(-steps);
    const double lag = -std::expm1(-steps) / steps;  // (1 - exp(-r)) / r
    remembered_ = kept * remembered_ + (lag - kept) * relaxed_ + (1 - lag) * relaxed_kPa;
  }
  relaxed_ = relaxed_kPa;
}

VectorXd FoamMemory::pressure_kPa() const {
  return foam_.prompt_share * relaxed_ + (1 - foam_.prompt_share) * remembered_;
}

}  // namespace ertbench
