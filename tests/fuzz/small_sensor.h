#pragma once

#include "forward/sheet/sensor.h"

namespace ertbench::fuzzing {

/// The sensor of the corpus (make_corpus): 40 channels and 64 pixels, so that files stay small.
inline Sensor small_sensor() {
  Sensor sensor;
  sensor.image_grid = 8;
  sensor.electrode_count = 8;
  sensor.electrode_offset = 0.5;
  return sensor;
}

}  // namespace ertbench::fuzzing
