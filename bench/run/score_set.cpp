#include "bench/run/score_set.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "bench/score/metric_summary.h"
#include "bench/score/metrics.h"
#include "forward/data/dataset_file.h"
#include "solvers/solver.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr std::uint64_t scored_frames = 256;

json numbers_or_null(const std::vector<FrameMetrics>& frames, Metric metric) {
  json out = json::array();
  for (const FrameMetrics& frame : frames) {
    out.push_back(frame[metric] ? json(*frame[metric]) : json());
  }
  return out;
}

/// Takes the frames in turn and keeps what is to be known of each.
class Scoring {
 public:
  Scoring(const Sensor& sensor, const std::vector<int>& figure_scenes)
      : sensor_(sensor), figure_scenes_(figure_scenes) {}

  void add(const Eigen::RowVectorXd& truth, const Eigen::RowVectorXd& image, const Scene& scene,
           const FrameReport& report) {
    const bool usable = report.status != FrameStatus::undefined && image.allFinite();
    const int index = static_cast<int>(metrics_.size());
    metrics_.push_back(usable ? frame_metrics(sensor_, truth, image, scene) : FrameMetrics{});
    row_.undefined_frames += !usable;
    row_.frames_not_converged += report.status == FrameStatus::not_converged;
    row_.suspect_frames += usable && report.status == FrameStatus::suspect;
    statuses_.push_back(static_cast<int>(usable ? report.status : FrameStatus::undefined));
    reasons_.push_back(report.reasons);
    iterations_.push_back(report.iterations);
    gaps_.push_back(report.gap);
    if (std::find(figure_scenes_.begin(), figure_scenes_.end(), index) != figure_scenes_.end()) {
      kept_[index] = std::vector<double>(image.begin(), image.end());
    }
  }

  ScoredFrames result() {
    row_.frames = static_cast<int>(metrics_.size());
    row_.metrics = summarise(metrics_);
    json frames = {{"status", std::move(statuses_)},
                   {"reasons", std::move(reasons_)},
                   {"iterations", std::move(iterations_)},
                   {"gap", std::move(gaps_)}};
    for (const Metric metric : kMetrics) {
      frames[name_of(metric)] = numbers_or_null(metrics_, metric);
    }
    json images = json::array();
    for (const int scene : figure_scenes_) images.push_back(kept_.at(scene));
    return {row_, std::move(frames), std::move(images)};
  }

 private:
  const Sensor& sensor_;
  const std::vector<int>& figure_scenes_;
  ResultRow row_;
  std::vector<FrameMetrics> metrics_;
  json statuses_ = json::array();
  json reasons_ = json::array();
  json iterations_ = json::array();
  json gaps_ = json::array();
  std::map<int, json> kept_;
};

}  // namespace

ScoredFrames score_set(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
                       const std::vector<int>& figure_scenes) {
  Scoring scoring(sensor, figure_scenes);
  for (std::uint64_t first = 0; first < set.size(); first += scored_frames) {
    const std::uint64_t count = std::min(scored_frames, set.size() - first);
    const Frames changes =
        set.voltages(first, count).rowwise() - set.reference_voltages().transpose();
    const Images truths = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    Images images(changes.rows(), sensor.pixels());
    std::vector<FrameReport> reports(count);
    solver.reconstruct(changes, images, reports);
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      scoring.add(truths.row(row), images.row(row), scenes[i], reports[i]);
    }
  }
  return scoring.result();
}

}  // namespace ertbench
