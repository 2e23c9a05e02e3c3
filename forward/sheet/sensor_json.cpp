#include "forward/sheet/sensor_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <system_error>

#include "core/errors.h"
#include "core/text.h"
#include "forward/sheet/sheet_shapes.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

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
      const double round = sensor.sheet->border_length();
      const double offset = lengths.length("electrode_offset", {-1e3 * round, 1e3 * round});
      sensor.electrode_offset = offset - round * std::floor(offset / round);
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

/// [[a, b, m, n], ...] to channels; `first` is the first electrode's number, if it is declared.
std::vector<ChannelElectrodes> channels_from_json(const nlohmann::json& list, int electrodes,
                                                  std::optional<int> first) {
  std::vector<std::array<int, 4>> channels;
  int least = electrodes;
  int most = 0;
  for (const nlohmann::json& four : list) {
    const auto is_whole = [](const nlohmann::json& e) { return e.is_number_integer(); };
    if (!four.is_array() || four.size() != 4 || !std::all_of(four.begin(), four.end(), is_whole)) {
      throw InputError(
          "must be the name of a file or a list of [a, b, m, n], drive and "
          "measurement, got " +
          json_shown(four));
    }
    channels.push_back(four.get<std::array<int, 4>>());
    least = std::min(least, *std::min_element(channels.back().begin(), channels.back().end()));
    most = std::max(most, *std::max_element(channels.back().begin(), channels.back().end()));
  }
  const auto span = std::to_string(least) + " to " + std::to_string(most);
  if (!first && least > 0 && most < electrodes) {
    throw InputError("names electrodes from " + span +
                     ", which may be counted from 0 or from 1; "
                     "say it in the sensor by \"count_from\"");
  }
  const int from = first.value_or(least == 0 ? 0 : 1);
  if (least < from || most >= from + electrodes) {
    throw InputError("names electrodes from " + span + "; counted from " + std::to_string(from) +
                     " the sensor has " + std::to_string(from) + " to " +
                     std::to_string(from + electrodes - 1));
  }
  std::vector<ChannelElectrodes> out;
  for (const auto& [a, b, m, n] : channels)
    out.push_back({{a - from, b - from}, {m - from, n - from}});
  return out;
}

/// The lines of a text file as such a list.
nlohmann::json lines_of_channels(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be opened; check the name and its rights");
  nlohmann::json out = nlohmann::json::array();
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    std::istringstream fields(line);
    std::array<int, 4> four{};
    fields >> std::ws;
    if (fields.eof() || fields.peek() == '#') continue;
    for (int& e : four) fields >> e;
    std::string rest;
    if (!fields || fields >> rest) {
      throw InputError(file.string() + ": line " + std::to_string(number) +
                       ": must be four whole numbers: drive a, b and measurement m, n");
    }
    out.push_back(four);
  }
  return out;
}

void read_channels(JsonObject& object, Sensor& sensor) {
  for (const char* key : {"drive", "measurement", "measures_driven"}) {
    if (object.has(key)) object.fail(key, "stands beside \"channels\"; remove one of the two");
  }
  std::optional<int> first;
  if (object.has("count_from")) first = object.integer("count_from", 0, 1);
  const nlohmann::json& value = object.raw("channels");
  try {
    const nlohmann::json list =
        value.is_string() ? lines_of_channels(object.folder() / value.get<std::string>()) : value;
    sensor = with_channels(sensor, channels_from_json(list, sensor.electrode_count, first));
  } catch (const InputError& wrong) {
    object.fail("channels", wrong.what());
  }
}

void read_pattern(JsonObject& object, Sensor& sensor) {
  if (object.has("channels")) {
    read_channels(object, sensor);
    return;
  }
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

void read_currents(JsonObject& object, Sensor& sensor) {
  // From the leakage of an insulator to the best of metals, whose voltages and their squares are
  // numbers of float32 as well.
  constexpr Range range{1e-9, 100, false, "A"};
  if (!object.has("drive_currents")) {
    sensor.drive_current = object.number_or("drive_current", sensor.drive_current, range);
    return;
  }
  if (object.has("drive_current")) {
    object.fail("drive_current", "stands beside \"drive_currents\"; remove one of the two");
  }
  const auto drives = static_cast<std::size_t>(sensor.drives());
  sensor.set_currents(object.numbers("drive_currents", drives, range));
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
  read_currents(object, sensor);
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
  nlohmann::json json = {{"image_grid", sensor.image_grid}, {"background", sensor.background}};
  if (sensor.drive_currents.empty()) {
    json["drive_current"] = sensor.drive_current;
  } else {
    json["drive_currents"] = sensor.drive_currents;
  }
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
  if (!sensor.listed_channels.empty()) {
    nlohmann::json& list = json["channels"] = nlohmann::json::array();
    for (const auto& [drive, measurement] : electrodes_of_channels(sensor)) {
      list.push_back({drive.first, drive.second, measurement.first, measurement.second});
    }
    json["count_from"] = 0;
  } else if (!sensor.is_adjacent()) {
    json["drive"] = to_json(sensor.drive);
    json["measurement"] = to_json(sensor.measurement);
  }
  if (sensor.measures_driven) json["measures_driven"] = true;
  if (sensor.skin) json["skin"] = to_json(*sensor.skin);
  return json;
}

nlohmann::json read_sensor_json(const fs::path& file) {
  nlohmann::json json = read_json_file(file);
  const Sensor sensor = sensor_from_json(JsonObject(json, file.string(), ""));
  if (json.contains("channels")) {  // a file's are read beside the sensor's, not beside another's
    const nlohmann::json listed = to_json(sensor);
    for (const char* key : {"channels", "count_from"}) json[key] = listed.at(key);
  }
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

std::vector<ChannelElectrodes> read_channels(const fs::path& file, int electrodes) {
  try {
    return channels_from_json(lines_of_channels(file), electrodes, std::nullopt);
  } catch (const InputError& wrong) {
    throw InputError(file.string() + ": " + wrong.what());
  }
}

}  // namespace ertbench
