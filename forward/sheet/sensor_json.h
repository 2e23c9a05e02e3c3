#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/json.h"
#include "forward/sheet/sensor.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// A sensor's file, `sensors/d2s.json`. Throws InputError at the file's own places.
Sensor read_sensor(const std::filesystem::path& file);
/// Its content as it stands, checked.
nlohmann::json read_sensor_json(const std::filesystem::path& file);

/// The lines "a b m n" of a text file (see sensor_from_json); throws InputError at the line.
std::vector<ChannelElectrodes> read_channels(const std::filesystem::path& file, int electrodes);

/// The file that a "sensor" names in `file`: beside it, in the folder above, or from the working
/// folder. Throws InputError that names all three where there is none.
std::filesystem::path find_sensor_file(const std::filesystem::path& named,
                                       const std::filesystem::path& file);

/// Reads lengths and places on a sheet out of a JSON object, each in one of two forms: "radius" in
/// domain units, or "radius_mm" in millimetres, places then from the middle of the sheet. What
/// comes out and the ranges that go in are in domain units. Both forms at once are refused.
class SheetLengths {
 public:
  /// Both live as long as the reader.
  SheetLengths(JsonObject& object, const Sheet& sheet) : object_(object), sheet_(sheet) {}

  bool has(const char* key) const;  ///< in either form, or both

  double length(const char* key, Range range);
  Eigen::Vector2d lengths(const char* key, Range range);  ///< along two axes
  /// A list of `least` to `most` lengths.
  std::vector<double> numbers(const char* key, std::size_t least, std::size_t most, Range range);
  /// [low, high], or one number for both.
  std::pair<double, double> length_interval(const char* key, Range range);
  /// Reads a place; the range bounds both distances from the origin of its form.
  Eigen::Vector2d place(const char* key, Range range);
  std::vector<Eigen::Vector2d> places(const char* key, std::size_t least, std::size_t most,
                                      Range range);
  /// Reads an interval of places along one axis, 0 for x and 1 for y: [low, high], or one number
  /// for both.
  std::pair<double, double> coordinate_interval(const char* key, int axis, Range range);

  /// Throws InputError at the key in the form that stands in the object.
  [[noreturn]] void fail(const char* key, const std::string& message) const;
  /// A length as messages show it, in the unit in which that of the key was given: "40 mm".
  std::string shown(const char* key, double length) const;

 private:
  /// How a key stands in the object: it says origin + number / unit, lengths without the origin.
  struct Form {
    std::string key;
    double unit;  ///< numbers to a domain unit
    Eigen::Vector2d origin;
    const char* unit_name;

    Range range(Range domain) const;
  };
  Form form_of(const char* key) const;

  JsonObject& object_;
  const Sheet& sheet_;
};

}  // namespace ertbench
