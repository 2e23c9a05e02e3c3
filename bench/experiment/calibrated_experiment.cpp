#include "bench/experiment/calibrated_experiment.h"

#include <nlohmann/json.hpp>

#include "bench/frames/calibrated_set.h"
#include "core/json_reader.h"

namespace ertbench {

std::optional<Calibration> read_calibration_of(JsonObject& root, Experiment& experiment) {
  if (!root.has("calibration")) return std::nullopt;
  std::filesystem::path file = root.text("calibration");
  if (file.is_relative()) file = experiment.file.parent_path() / file;
  Calibration calibration = read_calibration(file);
  if (root.has("sensor")) {
    require_calibration_of(calibration, experiment.sensor, file);
  } else {
    experiment.sensor = calibration.sensor;
  }
  experiment.sensor.background = calibration.background;
  experiment.files.push_back(std::move(file));
  return calibration;
}

void complete_with(const Calibration& calibration, Experiment& experiment) {
  if (experiment.validation) return;
  experiment.validation = calibrated_spec(calibration, experiment.sensor, "validation");
}

}  // namespace ertbench
