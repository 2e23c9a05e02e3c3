#include "forward/sheet/sensor_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <system_error>

#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "forward/sheet/sensor.h"
#include "forward/sheet/sheet_shapes.h"

namespace ertbench {
namespace {

constexpr Range side_range{1, 1e5, false, "mm"};
constexpr int fewest_electrodes = 5;
constexpr int most_electrodes = 64;  ///< as many as an ElectrodeSet holds

std::shared_ptr<const Sheet> sheet_from_json(JsonObject& object) {
  const std::string shape = object.choice_or("shape", "square", {"square", "rectangle", "disc"});
  if (shape == "disc")
    return std::make_shared<const DiscSheet>(object.number("diameter_mm", side_range));
  if (shape == "rectangle") {
    const std::vector<double> sides = object.numbers("sides_mm", 2, side_range);
    const double elongation = std::max(sides[0], sides[1]) / std::min(sides[0], sides[1]);
    if (elongation > RectangleSheet::most_elongation) {
      object.fail("sides_mm", "must be at most " + number_text(RectangleSheet::most_elongation) +
                                  " to 1, are " + number_text(elongation) + " to 1");
    }
    if (sides[0] != sides[1]) {
      return std::make_shared<const RectangleSheet>(Eigen::Vector2d(sides[0], sides[1]));
    }
    return std::make_shared<const SquareSheet>(sides[0]);
  }
  const double side_mm = square_sheet()->size_mm().x();
  const double wanted = object.number_or("side_mm", side_mm, side_range);
  return wanted == side_mm ? square_sheet() : std::make_shared<const SquareSheet>(wanted);
}

/// Half as many pixels again along the longer side as there are electrodes, a multiple of four.
int usual_image_grid(int electrodes) { return std::clamp(4 * ((3 * electrodes + 4) / 8), 12, 48); }

/// Of the point of the border next to `point`: the distance along the border from its start.
double place_beside(const Sheet& sheet, const Eigen::Vector2d& point) {
  constexpr int probes = 720;
  const double step = sheet.border_length() / probes;
  const auto distance = [&](double along) { return (sheet.border_point(along) - point).norm(); };
  double best = 0;
  for (int i = 1; i < probes; ++i) {
    if (distance(i * step) < distance(best)) best = i * step;
  }
  double low = best - step;
  double high = best + step;
  const double golden = (std::sqrt(5.0) - 1) / 2;
  while (high - low > 1e-12) {
    const double a = high - golden * (high - low);
    const double b = low + golden * (high - low);
    (distance(a) < distance(b) ? high : low) = distance(a) < distance(b) ? b : a;
  }
  return (low + high) / 2;
}

/// "electrode_places" (or "..._mm") or "electrode_points_mm"; empty where neither stands there.
std::vector<double> listed_places(JsonObject& object, SheetLengths& lengths, const Sheet& sheet) {
  const bool points = object.has("electrode_points_mm");
  const bool places = lengths.has("electrode_places");
  if (points && places) {
    object.fail("electrode_points_mm", "stands beside electrode_places; remove one of the two");
  }
  if (places) {
    return lengths.numbers("electrode_places", fewest_electrodes, most_electrodes,
                           {-sheet.border_length(), 2 * sheet.border_length()});
  }
  std::vector<double> out;
  if (!points) return out;
  for (const auto& [x, y] : object.points("electrode_points_mm", fewest_electrodes, most_electrodes,
                                          {-1e5, 1e5, false, "mm"})) {
    const Eigen::Vector2d point = sheet.bounds().center() + Eigen::Vector2d(x, y) / sheet.unit_mm();
    constexpr double farthest = 0.05;  // domain units
    if (std::abs(sheet.depth(point)) > farthest) {
      object.fail("electrode_points_mm",
                  "must be on the sheet's border, [" + number_text(x) + ", " + number_text(y) +
                      "] is " + number_text(std::abs(sheet.depth(point)) * sheet.unit_mm()) +
                      " mm from it");
    }
    out.push_back(place_beside(sheet, point));
  }
  return out;
}

/// Numbers electrodes against the clock: from the same first place, or in the order listed.
void turn_round(Sensor& sensor) {
  Eigen::VectorXd places = electrode_distances(sensor);
  const bool listed = !sensor.electrode_places.empty();
  sensor.electrode_places.clear();
  for (int e = 0; e < sensor.electrode_count; ++e) {
    sensor.electrode_places.push_back(listed ? -places[e] : 2 * places[0] - places[e]);
  }
}

void read_electrodes(JsonObject& object, Sensor& sensor) {
  SheetLengths lengths(object, *sensor.sheet);
  sensor.electrode_places = listed_places(object, lengths, *sensor.sheet);
  if (!sensor.electrode_places.empty()) {
    sensor.electrode_count = static_cast<int>(sensor.electrode_places.size());
    sensor.electrode_offset = 0;
    for (const char* key : {"electrode_count", "electrode_offset", "electrode_offset_mm"}) {
      if (object.has(key)) object.fail(key, "says again what the electrodes' list says; remove it");
    }
    if (!(sensor.electrode_spacing() > 1e-6)) {
      object.fail("", "two electrodes are listed at the same place of the border");
    }
  } else {
    sensor.electrode_count =
        object.integer_or("electrode_count", 16, fewest_electrodes, most_electrodes);
    const bool is_disc = sensor.sheet->name() == "disc";
    sensor.electrode_offset = is_disc ? 0 : sensor.electrode_spacing() / 2;
    if (lengths.has("electrode_offset")) {
      sensor.electrode_offset =
          lengths.length("electrode_offset", {0, sensor.sheet->border_length()});
    }
    if (sensor.electrode_offset >= sensor.electrode_spacing()) {
      lengths.fail("electrode_offset",
                   "must be less than the distance between electrodes, " +
                       lengths.shown("electrode_offset", sensor.electrode_spacing()));
    }
  }
  if (object.boolean_or("counterclockwise", false)) turn_round(sensor);
}

void read_widths(JsonObject& object, Sensor& sensor) {
  SheetLengths lengths(object, *sensor.sheet);
  const std::string model =
      object.choice_or("electrode_model", "point", {"point", "gap", "complete"});
  if (model == "point") {
    for (const char* key : {"electrode_width", "electrode_width_mm", "contact_impedance"}) {
      if (object.has(key)) {
        object.fail(key,
                    R"(is not for point electrodes; add "electrode_model": "gap" or "complete")");
      }
    }
    return;
  }
  const bool complete = model == "complete";
  sensor.electrode_model = complete ? ElectrodeModel::complete : ElectrodeModel::gap;
  sensor.electrode_width = lengths.length("electrode_width", {1e-6, sensor.sheet->border_length()});
  if (sensor.electrode_width > 0.98 * sensor.electrode_spacing()) {
    lengths.fail("electrode_width",
                 "must leave room between neighbours, which are " +
                     lengths.shown("electrode_width", sensor.electrode_spacing()) + " apart");
  }
  if (complete) {
    sensor.contact_impedance = object.number("contact_impedance", {0, 1e9, false, "ohm m^2"});
  } else if (object.has("contact_impedance")) {
    object.fail("contact_impedance", R"(is of "electrode_model": "complete" alone)");
  }
}

void read_pattern(JsonObject& object, Sensor& sensor) {
  const int count = sensor.electrode_count;
  sensor.drive = pair_pattern_from_json(object, "drive", {}, count);
  const bool repeats = sensor.drive.kind != PairPattern::Kind::opposite;
  sensor.measurement =
      pair_pattern_from_json(object, "measurement", repeats ? sensor.drive : PairPattern{}, count);
  sensor.measures_driven = object.boolean_or("measures_driven", false);
  if (sensor.measures_driven && sensor.electrode_model == ElectrodeModel::point) {
    object.fail("measures_driven",
                "needs electrodes with a width: at a point that is driven the potential is "
                R"(infinite; add "electrode_model", or leave these channels out)");
  }
  if (sensor.channels() < 4) {
    object.fail("measurement", "leaves " + std::to_string(sensor.channels()) +
                                   " channels that share no electrode with the drive; needs 4");
  }
}

}  // namespace

Sensor sensor_from_json(JsonObject object) {
  Sensor sensor;
  object.has("$schema");  // for editors
  if (object.has("about")) object.text("about");
  sensor.sheet = sheet_from_json(object);
  read_electrodes(object, sensor);
  read_widths(object, sensor);
  read_pattern(object, sensor);
  sensor.image_grid =
      object.integer_or("image_grid", usual_image_grid(sensor.electrode_count), 4, 96);
  if (std::min(sensor.image_columns(), sensor.image_rows()) < 4) {
    object.fail("image_grid", "leaves fewer than 4 pixels along the shorter side");
  }
  // From the leakage of an insulator to the best of metals, whose voltages and their squares are
  // numbers of float32 as well.
  sensor.drive_current =
      object.number_or("drive_current", sensor.drive_current, {1e-9, 100, false, "A"});
  sensor.background = object.number_or("background", sensor.background, {1e-9, 1e8, false, "S/m"});
  if (object.has("skin")) {
    if (sensor.sheet->name() != "square") {
      object.fail("skin", "is of square sheets; leave it out for a " + sensor.sheet->name());
    }
    sensor.skin = skin_from_json(object.object("skin"), sensor.sheet->size_mm().x());
  }
  object.finish();
  return sensor;
}

nlohmann::json to_json(const Sensor& sensor) {
  nlohmann::json json = {{"image_grid", sensor.image_grid},
                         {"drive_current", sensor.drive_current},
                         {"background", sensor.background}};
  if (sensor.electrode_places.empty()) {
    json["electrode_count"] = sensor.electrode_count;
    json["electrode_offset"] = sensor.electrode_offset;
  } else {
    json["electrode_places"] = sensor.electrode_places;
  }
  // Left out where they are what they were before there was a choice, so that the names of older
  // datasets stay what they are.
  const Sheet& sheet = *sensor.sheet;
  if (sheet.name() == "disc") {
    json["shape"] = "disc";
    json["diameter_mm"] = sheet.size_mm().x();
  } else if (sheet.name() == "rectangle") {
    json["shape"] = "rectangle";
    json["sides_mm"] = {sheet.size_mm().x(), sheet.size_mm().y()};
  } else if (sheet.unit_mm() != square_sheet()->unit_mm()) {
    json["side_mm"] = sheet.size_mm().x();
  }
  if (sensor.electrode_model != ElectrodeModel::point) {
    const bool complete = sensor.electrode_model == ElectrodeModel::complete;
    json["electrode_model"] = complete ? "complete" : "gap";
    json["electrode_width"] = sensor.electrode_width;
    if (complete) json["contact_impedance"] = sensor.contact_impedance;
  }
  if (!sensor.is_adjacent()) {
    json["drive"] = to_json(sensor.drive);
    json["measurement"] = to_json(sensor.measurement);
  }
  if (sensor.measures_driven) json["measures_driven"] = true;
  if (sensor.skin) json["skin"] = to_json(*sensor.skin);
  return json;
}

namespace fs = std::filesystem;

nlohmann::json read_sensor_json(const fs::path& file) {
  nlohmann::json json = read_json_file(file);
  sensor_from_json(JsonObject(json, file.string(), ""));  // at the file's own places
  return json;
}

Sensor read_sensor(const fs::path& file) {
  const nlohmann::json json = read_json_file(file);
  return sensor_from_json(JsonObject(json, file.string(), ""));
}

fs::path find_sensor_file(const fs::path& named, const fs::path& file) {
  const fs::path folder = file.parent_path();
  const fs::path beside = folder / named;
  const fs::path above = folder / ".." / named;
  for (const fs::path& place : {beside, above, named}) {
    std::error_code absent;
    if (fs::is_regular_file(place, absent)) return place.lexically_normal();
  }
  throw InputError("no file " + named.string() + ": neither beside " + file.string() +
                   ", nor in the folder above, nor from here; name a sensor's file, such as "
                   "sensors/d2s.json");
}

namespace {

std::string in_mm(const char* key) { return std::string(key) + "_mm"; }

}  // namespace

Range SheetLengths::Form::range(Range domain) const {
  return {unit * domain.low, unit * domain.high, domain.low_open, unit_name};
}

bool SheetLengths::has(const char* key) const {
  const bool domain = object_.has(key);  // both are known keys, whichever of them stands there
  return object_.has(in_mm(key)) || domain;
}

SheetLengths::Form SheetLengths::form_of(const char* key) const {
  const bool domain = object_.has(key);
  const bool millimetres = object_.has(in_mm(key));
  if (domain && millimetres) {
    object_.fail(in_mm(key), "stands beside \"" + std::string(key) +
                                 "\", which says the same in domain units; remove one of the two");
  }
  if (millimetres) return {in_mm(key), sheet_.unit_mm(), sheet_.bounds().center(), "mm"};
  return {key, 1, Eigen::Vector2d::Zero(), ""};
}

double SheetLengths::length(const char* key, Range range) {
  const Form form = form_of(key);
  return object_.number(form.key, form.range(range)) / form.unit;
}

Eigen::Vector2d SheetLengths::lengths(const char* key, Range range) {
  const Form form = form_of(key);
  const std::vector<double> two = object_.numbers(form.key, 2, form.range(range));
  return Eigen::Vector2d(two[0], two[1]) / form.unit;
}

std::vector<double> SheetLengths::numbers(const char* key, std::size_t least, std::size_t most,
                                          Range range) {
  const Form form = form_of(key);
  const std::size_t size = object_.raw(form.key).size();
  if (size < least || size > most) {
    object_.fail(form.key, "must be a list of " + std::to_string(least) + " to " +
                               std::to_string(most) + " numbers, holds " + std::to_string(size));
  }
  std::vector<double> out = object_.numbers(form.key, size, form.range(range));
  for (double& number : out) number /= form.unit;
  return out;
}

std::pair<double, double> SheetLengths::length_interval(const char* key, Range range) {
  const Form form = form_of(key);
  const auto [low, high] = object_.interval(form.key, form.range(range));
  return {low / form.unit, high / form.unit};
}

Eigen::Vector2d SheetLengths::place(const char* key, Range range) {
  return form_of(key).origin + lengths(key, range);
}

std::vector<Eigen::Vector2d> SheetLengths::places(const char* key, std::size_t least,
                                                  std::size_t most, Range range) {
  const Form form = form_of(key);
  std::vector<Eigen::Vector2d> out;
  for (const auto& [x, y] : object_.points(form.key, least, most, form.range(range))) {
    out.emplace_back(form.origin + Eigen::Vector2d(x, y) / form.unit);
  }
  return out;
}

std::pair<double, double> SheetLengths::coordinate_interval(const char* key, int axis,
                                                            Range range) {
  const double origin = form_of(key).origin[axis];
  range.low -= origin;
  range.high -= origin;
  const auto [low, high] = length_interval(key, range);
  return {origin + low, origin + high};
}

void SheetLengths::fail(const char* key, const std::string& message) const {
  object_.fail(form_of(key).key, message);
}

std::string SheetLengths::shown(const char* key, double length) const {
  const Form form = form_of(key);
  return number_text(form.unit * length) + (*form.unit_name ? " " : "") + form.unit_name;
}

}  // namespace ertbench
