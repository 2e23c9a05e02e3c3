#include "bench/frames/calibrated_set.h"

#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "core/json_reader.h"
#include "core/random.h"
#include "forward/data/dataset_file.h"
#include "forward/data/dataset_layout.h"
#include "forward/data/generate.h"

namespace ertbench {
namespace {

constexpr std::uint64_t scenes = 400;
constexpr const char* set_name = "calibrated";

}  // namespace

DatasetSpec calibrated_spec(const Calibration& calibration, const Sensor& sensor,
                            const std::string& name) {
  const nlohmann::json json = {{"count", scenes},         {"seed", 1},
                               {"grid", "auto"},          {"snr_db", calibration.snr_absolute},
                               {"snr_basis", "absolute"}, {"scenes", {{"contacts", {0, 3}}}}};
  Sensor fitted = sensor;
  fitted.background = calibration.background;
  return dataset_spec_from_json(JsonObject(json, "calibration", ""), fitted, name);
}

void write_calibrated_set(const Calibration& calibration, const Sensor& sensor,
                          const std::filesystem::path& file, int threads) {
  const DatasetSpec spec = calibrated_spec(calibration, sensor, set_name);
  generate_dataset(spec, file, {threads, {}});
  Frames voltages = DatasetFile(file).clean_voltages(0, spec.count);
  for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
    RandomStream random = spec.noise_stream(static_cast<std::uint64_t>(f));
    for (Eigen::Index c = 0; c < voltages.cols(); ++c) {
      voltages(f, c) += calibration.noise[c] * random.normal();
    }
  }
  Hdf5File out = Hdf5File::open_writable(file);
  out.write_rows(dataset_layout::voltages, 0, voltages);
  out.write_checksum();
  out.close();
}

}  // namespace ertbench
