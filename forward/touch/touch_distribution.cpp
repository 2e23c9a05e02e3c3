#include "forward/touch/touch_distribution.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

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

/// A fingertip may point anywhere.
Indenter turned(Indenter indenter, double angle) {
  if (auto* face = std::get_if<FlatFace>(&indenter.body)) {
    face->angle += angle;
    const Eigen::Rotation2Dd turn(angle);
    for (Vector2d& vertex : face->vertices_mm) vertex = turn * vertex;
  }
  return indenter;
}

/// Of the circle around the indenter's face; of a ball, around what touches of it at 10 N on the
/// softest of usual foams: half its radius.
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

PlaceGrid place_grid_from_json(JsonObject object, const Sensor& sensor) {
  const Vector2d size = sensor.sheet->size_mm();
  PlaceGrid grid;
  const std::vector<int> cells = object.integers("grid", 2, 2, {1, 1000});
  grid.columns = cells[0];
  grid.rows = cells[1];
  const auto pair = [&](const char* key, const Vector2d& otherwise) -> Vector2d {
    if (!object.has(key)) return otherwise;
    const std::vector<double> xy = object.numbers(key, 2, {-1e5, 1e5, false, "mm"});
    return {xy[0], xy[1]};
  };
  grid.spacing_mm = pair("spacing_mm", {size.x() / grid.columns, size.y() / grid.rows});
  grid.shift_mm = pair("shift_mm", {0, 0});
  object.finish();
  for (const int index : {0, grid.count() - 1}) {
    if (sensor.sheet->depth(grid.place_mm(index) / sensor.sheet->unit_mm()) < 0) {
      object.fail("", "must lie on the sheet of " + nlohmann::json(size.x()).dump() + " mm");
    }
  }
  return grid;
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
      // At the wanted distance from the nearest, on the sheet; where no direction has room, the
      // scene has a touch less.
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
  const double side = sensor.sheet->size_mm().x();
  TouchDistribution d;
  d.touches = object.integer_interval("touches", 0, 32);
  d.indenters.clear();
  for (const JsonObject& indenter : object.objects("indenters")) {
    d.indenters.push_back(indenter_from_json(indenter));
  }
  if (d.indenters.empty()) object.fail("indenters", "must name at least one");
  if (object.has("size")) d.size = object.interval("size", {0.01, 100});
  d.force_N = object.interval("force_N", {1e-6, 1e4, false, "N"});
  d.margin_mm = object.number_or("margin_mm", d.margin_mm, {0, 0.45 * side, false, "mm"});
  if (object.has("gap_mm")) d.gap_mm = object.interval("gap_mm", {-0.5 * side, side});
  if (object.has("places")) {
    d.places = place_grid_from_json(object.object("places"), sensor);
    if (d.touches != std::pair(1, 1)) object.fail("places", R"(are of scenes with "touches": 1)");
  }
  d.draws = object.integer_or("draws", 1, 1, 1000000);
  d.blank_fraction = object.number_or("blank_fraction", 0, {0, 1});
  object.finish();
  return d;
}

nlohmann::json to_json(const TouchDistribution& d) {
  const auto both = [](const auto& interval) {
    return nlohmann::json{interval.first, interval.second};
  };
  nlohmann::json json = {{"touches", both(d.touches)},
                         {"indenters", nlohmann::json::array()},
                         {"size", both(d.size)},
                         {"force_N", both(d.force_N)},
                         {"margin_mm", d.margin_mm},
                         {"draws", d.draws},
                         {"blank_fraction", d.blank_fraction}};
  for (const Indenter& indenter : d.indenters) json["indenters"].push_back(to_json(indenter));
  if (d.gap_mm) json["gap_mm"] = both(*d.gap_mm);
  if (d.places) {
    json["places"] = {{"grid", {d.places->columns, d.places->rows}},
                      {"spacing_mm", {d.places->spacing_mm.x(), d.places->spacing_mm.y()}},
                      {"shift_mm", {d.places->shift_mm.x(), d.places->shift_mm.y()}}};
  }
  return json;
}

}  // namespace ertbench
