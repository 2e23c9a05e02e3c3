#include "solvers/export/runtime_file.h"

#include <algorithm>
#include <filesystem>

#include "forward/data/sheet_model.h"

namespace ertbench {
namespace {

constexpr double empty_image = 1e-9;  ///< share of the background: kEmptyImage of bench/score

}  // namespace

runtime::LayerFile sensor_and_rule(const CExport& how) {
  const PixelGrid pixels = how.sensor.image();
  const double mm = how.sensor.sheet->unit_mm();
  const Eigen::VectorXf reference = uniform_reference(how.sensor).cast<float>();
  runtime::LayerFile out;
  out.name = std::filesystem::path(how.name).stem().string();
  out.channels = how.sensor.channels();
  out.rows = how.sensor.image_rows();
  out.columns = how.sensor.image_columns();
  out.reference.assign(reference.begin(), reference.end());
  for (int p = 0; p < pixels.count(); ++p) {
    if (!pixels.on_sheet(p)) out.no_sheet.push_back(p);
  }
  out.threshold = static_cast<float>(how.rule.threshold);
  out.floor = static_cast<float>(std::max(how.rule.floor, empty_image) * how.sensor.background);
  out.saddle = static_cast<float>(how.rule.saddle);
  out.x_mm = static_cast<float>(mm * pixels.centre(0).x());
  out.y_mm = static_cast<float>(mm * pixels.centre(0).y());
  out.width_mm = static_cast<float>(mm * pixels.pixel().x());
  out.height_mm = static_cast<float>(mm * pixels.pixel().y());
  return out;
}

std::map<std::string, std::string> runtime_file(const LayerList& list, const CExport& how) {
  runtime::LayerFile file = sensor_and_rule(how);
  file.list = list;
  file.front = how.front;
  return {{file.name + ".ert", runtime::bytes_of(file)}};
}

}  // namespace ertbench
