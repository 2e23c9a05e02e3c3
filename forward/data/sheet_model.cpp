#include "forward/data/sheet_model.h"

#include <atomic>
#include <iostream>

#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

/// True if the grid model applies; reports its replacement once.
bool grid_serves(const Sensor& sensor) {
  if (fits_grid(sensor, sensor.image_grid)) return true;
  static std::atomic<bool> is_said = false;
  if (!is_said.exchange(true)) {
    std::cerr << "sensor: finite elements on the image's pixels do not serve this "
              << sensor.sheet->name() << "; its Jacobian is that of the continuous sheet\n";
  }
  return false;
}

}  // namespace

Eigen::VectorXd uniform_reference(const Sensor& sensor) {
  if (grid_serves(sensor)) return ForwardModel(sensor, sensor.image_grid).reference_voltages();
  return BorderModel(sensor).reference_voltages();
}

RowMajorMatrix uniform_jacobian(const Sensor& sensor) {
  if (grid_serves(sensor)) return ForwardModel(sensor, sensor.image_grid).jacobian();
  return border_jacobian(sensor);
}

}  // namespace ertbench
