#include "forward/touch/touch_distribution.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/fields.h"
#include "core/json.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

using Eigen::Vector2d;

namespace {

Indenter scaled(Indenter indenter, double factor) {
  if (auto* ball = std::get_if<Sphere>(&indenter.body)) {
    ball->radius_mm *= factor;
    return indenter;
  }
  auto& face = std::get<FlatFace>(indenter.body);
  face.semi_axes_mm *= factor;
  for (Vector2d& vertex : face.vertices_mm) vertex *= factor;
  return indenter;
}

/// Turns the indenter, whose direction is random.
Indenter turned(Indenter indenter, double angle) {
  if (auto* face = std::get_if<FlatFace>(&indenter.body)) {
    face->angle += angle;
    const Eigen::Rotation2Dd turn(angle);
    for (Vector2d& vertex : face->vertices_mm) vertex = turn * vertex;
  }
  return indenter;
}

/// Radius of the circle around the indenter's face. For a ball half its radius: its contact at 10 N
/// on the softest of usual foams.
double radius_mm(const Indenter& indenter) {
  if (const auto* ball = std::get_if<Sphere>(&indenter.body)) return ball->radius_mm / 2;
  const auto& face = std::get<FlatFace>(indenter.body);
  if (face.vertices_mm.empty()) return face.semi_axes_mm.maxCoeff();
  double most = 0;
  for (const Vector2d& vertex : face.vertices_mm) most = std::max(most, vertex.norm());
  return most;
}

double gap_to_nearest(const Touch& touch, const std::vector<Touch>& others) {
  double least = INFINITY;
  for (const Touch& other : others) {
    least = std::min(least, (touch.place_mm - other.place_mm).norm() - radius_mm(touch.indenter) -
                                radius_mm(other.indenter));
  }
  return least;
}

void visit(Fields& fields, PlaceGrid& grid, const Sheet& sheet) {
  std::array<int, 2> cells = {grid.columns, grid.rows};
  fields.required().integers("grid", cells, {1, 1000});
  const Vector2d size = sheet.size_mm();
  if (fields.reading()) {
    grid = {cells[0], cells[1], {size.x() / cells[0], size.y() / cells[1]}, {0, 0}};
  }
  constexpr Range places{-1e5, 1e5, false, "mm"};
  fields.derived().numbers("spacing_mm", {grid.spacing_mm.data(), 2}, places);
  fields.numbers("shift_mm", {grid.shift_mm.data(), 2}, places);
  if (!fields.reading()) return;
  for (const int index : {0, grid.count() - 1}) {
    if (sheet.depth(grid.place_mm(index) / sheet.unit_mm()) < 0) {
      fields.fail("", "must lie on the sheet of " + nlohmann::json(size.x()).dump() + " mm");
    }
  }
}

/// All fields except the indenters.
void visit(Fields& fields, TouchDistribution& d, const Sheet& sheet) {
  const double side = fields.describing() ? INFINITY : sheet.size_mm().x();
  fields.required().interval("touches", d.touches, 0, 32);
  fields.interval("size", d.size, {0.01, 100});
  fields.required().interval("force_N", d.force_N, {1e-6, 1e4, false, "N"});
  fields.number("margin_mm", d.margin_mm, {0, 0.45 * side, false, "mm"});
  fields.interval("gap_mm", d.gap_mm, {-0.5 * side, side});
  fields.object("places", d.places,
                [&](Fields& places, PlaceGrid& grid) { visit(places, grid, sheet); });
  if (d.places && d.touches != std::pair(1, 1)) {
    fields.fail("places", R"(are of scenes with "touches": 1)");
  }
  fields.integer("draws", d.draws, 1, 1000000);
  fields.number("blank_fraction", d.blank_fraction, {0, 1});
}

}  // namespace

Vector2d PlaceGrid::place_mm(int index) const {
  const Vector2d cell(index % columns - (columns - 1) / 2.0, index / columns - (rows - 1) / 2.0);
  return spacing_mm.cwiseProduct(cell) + shift_mm;
}

std::vector<Touch> TouchDistribution::draw(std::uint64_t index, RandomStream& random,
                                           const Sensor& sensor) const {
  std::vector<Touch> drawn;
  if (random.uniform() < blank_fraction) return drawn;
  const int count = random.integer(touches.first, touches.second);
  const double reach = sensor.sheet->size_mm().x() / 2 - margin_mm;
  const auto anywhere = [&] {
    const double x = random.uniform(-reach, reach);
    return Vector2d(x, random.uniform(-reach, reach));
  };
  for (int t = 0; t < count; ++t) {
    Touch touch;
    const auto kind =
        static_cast<std::size_t>(random.integer(0, static_cast<int>(indenters.size()) - 1));
    const double factor = random.uniform(size.first, size.second);
    const double angle = random.uniform(0, std::numbers::pi);
    touch.indenter = places ? indenters[kind] : turned(indenters[kind], angle);
    if (factor != 1) touch.indenter = scaled(std::move(touch.indenter), factor);
    touch.force_N = random.uniform(force_N.first, force_N.second);
    if (places) {
      touch.place_mm = places->place_mm(
          static_cast<int>(scene_of(index) % static_cast<std::uint64_t>(places->count())));
    } else {
      touch.place_mm = anywhere();
    }
    if (gap_mm && t > 0) {
      // At the wanted distance from the nearest, on the sheet. If no direction has room, the scene
      // has fewer touches.
      bool fits = false;
      for (int attempt = 0; attempt < 2000 && !fits; ++attempt) {
        const Touch& other = drawn[static_cast<std::size_t>(random.integer(0, t - 1))];
        const double direction = random.uniform(0, 2 * std::numbers::pi);
        const double gap = random.uniform(gap_mm->first, gap_mm->second);
        touch.place_mm =
            other.place_mm + (gap + radius_mm(other.indenter) + radius_mm(touch.indenter)) *
                                 Vector2d(std::cos(direction), std::sin(direction));
        fits = touch.place_mm.cwiseAbs().maxCoeff() <= reach &&
               gap_to_nearest(touch, drawn) >= gap_mm->first - 1e-9;
      }
      if (!fits) break;
    }
    drawn.push_back(std::move(touch));
  }
  return drawn;
}

TouchDistribution touch_distribution_from_json(JsonObject object, const Sensor& sensor) {
  if (!sensor.skin) {
    object.fail("touches", R"(need a sensor with a skin: give "sensor" a "skin", such as {})");
  }
  TouchDistribution d;
  d.indenters.clear();
  for (const JsonObject& indenter : object.objects("indenters")) {
    d.indenters.push_back(indenter_from_json(indenter));
  }
  if (d.indenters.empty()) object.fail("indenters", "must name at least one");
  Fields::read(object, [&](Fields& fields) { visit(fields, d, *sensor.sheet); });
  return d;
}

nlohmann::json to_json(const TouchDistribution& distribution) {
  TouchDistribution d = distribution;
  nlohmann::json json = Fields::written([&](Fields& fields) { visit(fields, d, *square_sheet()); });
  for (const Indenter& indenter : d.indenters) json["indenters"].push_back(to_json(indenter));
  return json;
}

nlohmann::ordered_json touches_schema() {
  TouchDistribution d;
  nlohmann::ordered_json schema =
      Fields::schema([&](Fields& fields) { visit(fields, d, *square_sheet()); });
  schema["required"].push_back("indenters");
  return schema;
}

}  // namespace ertbench
