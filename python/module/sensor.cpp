#include "forward/sheet/sensor.h"

#include <nlohmann/json.hpp>

#include "core/json.h"
#include "python/module/arrays.h"

namespace ertbench {
namespace {

/// Points [2, n] in domain units as an array [n, 2], mm from the middle of the sheet.
Array points_mm(const Sensor& sensor, const Eigen::Matrix2Xd& points) {
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  const RowMajorMatrix rows = sensor.sheet->unit_mm() * (points.colwise() - middle).transpose();
  return array_of(rows, {rows.rows(), 2});
}

Array centres_mm(const Sensor& sensor, int axis) {
  const PixelGrid pixels = sensor.image();
  const Eigen::RowVectorXd centres = axis == 0 ? pixels.centres_x() : pixels.centres_y();
  const double middle = sensor.sheet->bounds().center()[axis];
  return array_of(sensor.sheet->unit_mm() * (centres.array() - middle).matrix(), {centres.size()});
}

py::array_t<bool> on_sheet(const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  py::array_t<bool> out({pixels.rows(), pixels.columns()});
  for (int i = 0; i < pixels.count(); ++i) out.mutable_data()[i] = pixels.on_sheet(i);
  return out;
}

/// [channels, 4]: the two electrodes of the drive, then those of the measurement.
py::array_t<int> channel_electrodes(const Sensor& sensor) {
  py::array_t<int> out({sensor.channels(), 4});
  int* next = out.mutable_data();
  for (const auto& [drive, measurement] : electrodes_of_channels(sensor)) {
    for (const int e : {drive.first, drive.second, measurement.first, measurement.second}) {
      *next++ = e;
    }
  }
  return out;
}

py::array_t<int> pairs_array(const Sensor& sensor) {
  const std::vector<std::array<int, 2>> pairs = reciprocal_pairs(sensor);
  py::array_t<int> out({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}});
  int* next = out.mutable_data();
  for (const auto& pair : pairs) next = std::copy(pair.begin(), pair.end(), next);
  return out;
}

py::tuple symmetry_arrays(const Sensor& sensor) {
  const std::vector<Symmetry> all = symmetries(sensor);
  const auto table = [&](const std::vector<int> Symmetry::*part, int width) {
    py::array_t<int> out({static_cast<int>(all.size()), width});
    int* next = out.mutable_data();
    for (const Symmetry& one : all) next = std::copy((one.*part).begin(), (one.*part).end(), next);
    return out;
  };
  return py::make_tuple(table(&Symmetry::pixels, sensor.pixels()),
                        table(&Symmetry::channels, sensor.channels()));
}

}  // namespace

void bind_sensor(py::module_& module) {
  py::class_<Sensor>(module, "Sensor")
      .def(py::init([](const std::string& text, const std::string& source) {
             const nlohmann::json json = parse_json(text, source);
             return sensor_from_json(JsonObject(json, source, ""));
           }),
           py::arg("text"), py::arg("source") = "sensor")
      .def("to_json", [](const Sensor& s) { return json_text(to_json(s)); })
      .def_property_readonly("shape", [](const Sensor& s) { return s.sheet->name(); })
      .def_property_readonly("channels", &Sensor::channels)
      .def_property_readonly("electrodes", [](const Sensor& s) { return s.electrode_count; })
      .def_property_readonly(
          "image_shape",
          [](const Sensor& s) { return py::make_tuple(s.image_rows(), s.image_columns()); })
      .def_property_readonly("background", [](const Sensor& s) { return s.background; })
      .def_property_readonly("drive_current", [](const Sensor& s) { return s.drive_current; })
      .def_property_readonly("unit_mm", [](const Sensor& s) { return s.sheet->unit_mm(); })
      .def_property_readonly("size_mm",
                             [](const Sensor& s) {
                               const Eigen::Vector2d size = s.sheet->size_mm();
                               return py::make_tuple(size.x(), size.y());
                             })
      .def_property_readonly("x_mm", [](const Sensor& s) { return centres_mm(s, 0); })
      .def_property_readonly("y_mm", [](const Sensor& s) { return centres_mm(s, 1); })
      .def_property_readonly("electrodes_mm",
                             [](const Sensor& s) { return points_mm(s, electrode_positions(s)); })
      .def_property_readonly("on_sheet", &on_sheet)
      .def_property_readonly("channel_electrodes", &channel_electrodes)
      .def_property_readonly("reciprocal_pairs", &pairs_array)
      .def("symmetries", &symmetry_arrays)
      .def(
          "__eq__", [](const Sensor& a, const Sensor& b) { return a == b; }, py::is_operator());
}

}  // namespace ertbench
