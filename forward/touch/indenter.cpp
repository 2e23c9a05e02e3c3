#include "forward/touch/indenter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/json_reader.h"
#include "core/text.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {

using Eigen::Vector2d;
using std::numbers::pi;

namespace {

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

}  // namespace

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

}  // namespace ertbench
