#include "bench/run/reference_rows.h"

#include "bench/score/metric_summary.h"
#include "forward/data/dataset_file.h"

namespace ertbench {

std::vector<ResultRow> reference_rows(const Experiment& experiment, const Cache& cache) {
  std::vector<ResultRow> rows;
  for (const DatasetSpec& test : experiment.tests) {
    const DatasetFile set(cache.dataset(test));
    std::vector<FrameMetrics> truth;
    std::vector<FrameMetrics> empty;
    const Eigen::RowVectorXd nothing = Eigen::RowVectorXd::Zero(experiment.sensor.pixels());
    constexpr std::uint64_t block = 256;
    for (std::uint64_t first = 0; first < set.size(); first += block) {
      const std::uint64_t count = std::min(block, set.size() - first);
      const Images images = set.conductivity(first, count);
      const std::vector<Scene> scenes = set.scenes(first, count);
      for (std::size_t i = 0; i < count; ++i) {
        const Eigen::RowVectorXd image = images.row(static_cast<Eigen::Index>(i));
        const Eigen::RowVectorXd change = image.array() - experiment.sensor.background;
        truth.push_back(frame_metrics(experiment.sensor, image, change, scenes[i]));
        empty.push_back(frame_metrics(experiment.sensor, image, nothing, scenes[i]));
      }
    }
    for (const bool is_truth : {true, false}) {
      ResultRow row;
      row.label = row.type = is_truth ? "truth" : "no-contact";
      row.dataset = test.name;
      row.frames = static_cast<int>(set.size());
      row.metrics = summarise(is_truth ? truth : empty);
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace ertbench
