#include "bench/run/score_set.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "bench/contacts/frame_reading.h"
#include "bench/contacts/image_contacts.h"
#include "bench/record/frame_reading_record.h"
#include "bench/score/explained_change.h"
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

bool is_usable(const FrameReport& report, const Eigen::Ref<const Eigen::RowVectorXd>& image) {
  return report.status != FrameStatus::undefined && image.allFinite();
}

bool is_finite(const FoundContact& contact) {
  return contact.place.allFinite() && std::isfinite(contact.strength) &&
         std::isfinite(contact.peak) && std::isfinite(contact.area);
}

/// The contacts of some frames: those that the solver knows, else those that the rule reads out of
/// its images.
class Contacts {
 public:
  Contacts(const Sensor& sensor, const Solver& solver, const ContactRule& rule)
      : finder_(solver.contact_finder()), rule_(rule), reader_(sensor) {}

  std::vector<std::vector<FoundContact>> of(const Frames& changes, const Images& images,
                                            std::span<const FrameReport> reports) {
    std::vector<std::vector<FoundContact>> found(reports.size());
    if (finder_) {
      finder_->find_contacts(changes, found);
      // A contact that is nowhere is none.
      for (auto& contacts : found) std::erase_if(contacts, std::not_fn(is_finite));
      return found;
    }
    for (std::size_t f = 0; f < found.size(); ++f) {
      const auto image = images.row(static_cast<Eigen::Index>(f));
      if (is_usable(reports[f], image)) reader_.read(rule_, image, found[f]);
    }
    return found;
  }

 private:
  const ContactFinder* finder_;
  ContactRule rule_;
  ContactReader reader_;
};

/// Takes the frames in turn and keeps what is to be known of each.
class Scoring {
 public:
  Scoring(const Sensor& sensor, const ScoreRequest& request, const Truth& truth)
      : sensor_(sensor), request_(request), truth_(truth) {}

  /// `found` is of no use where the frame has no usable image.
  void add(const Eigen::RowVectorXd& truth, const Eigen::RowVectorXd& image, const Scene& scene,
           const FrameReport& report, std::span<const FoundContact> found,
           const std::optional<double>& explained) {
    const bool usable = is_usable(report, image);
    const int index = static_cast<int>(metrics_.size());
    metrics_.push_back(
        usable ? frame_metrics(sensor_, truth, image, scene, {found, request_.distances})
               : FrameMetrics{});
    if (request_.keep_contacts) {
      FrameReading reading = usable ? frame_reading(sensor_, image, found) : FrameReading{};
      reading.explained = explained;
      readings_.push_back(to_json(reading));
    }
    row_.undefined_frames += !usable;
    row_.frames_not_converged += report.status == FrameStatus::not_converged;
    row_.suspect_frames += usable && report.status == FrameStatus::suspect;
    statuses_.push_back(static_cast<int>(usable ? report.status : FrameStatus::undefined));
    reasons_.push_back(report.reasons);
    iterations_.push_back(report.iterations);
    gaps_.push_back(report.gap);
    const std::vector<int>& scenes = request_.figure_scenes;
    if (std::find(scenes.begin(), scenes.end(), index) != scenes.end()) {
      kept_[index] = std::vector<double>(image.begin(), image.end());
    }
  }

  ScoredFrames result() {
    row_.frames = static_cast<int>(metrics_.size());
    row_.metrics = summarise(metrics_, truth_);
    json frames = {{"status", std::move(statuses_)},
                   {"reasons", std::move(reasons_)},
                   {"iterations", std::move(iterations_)},
                   {"gap", std::move(gaps_)}};
    for (const Metric metric : kMetrics) {
      if (is_known(metric, truth_)) frames[name_of(metric)] = numbers_or_null(metrics_, metric);
    }
    if (request_.keep_contacts) frames["readings"] = std::move(readings_);
    json images = json::array();
    for (const int scene : request_.figure_scenes) images.push_back(kept_.at(scene));
    return {row_, std::move(frames), std::move(images)};
  }

 private:
  const Sensor& sensor_;
  const ScoreRequest& request_;
  Truth truth_;
  ResultRow row_;
  std::vector<FrameMetrics> metrics_;
  json statuses_ = json::array();
  json reasons_ = json::array();
  json iterations_ = json::array();
  json gaps_ = json::array();
  json readings_ = json::array();
  std::map<int, json> kept_;
};

}  // namespace

ScoredFrames score_set(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
                       const ScoreRequest& request) {
  Scoring scoring(sensor, request, set.truth());
  std::optional<ExplainedChange> explained;
  if (request.keep_explained) explained.emplace(sensor, set.reference_voltages());
  Contacts contacts(sensor, solver, request.rule);
  for (std::uint64_t first = 0; first < set.size(); first += scored_frames) {
    const std::uint64_t count = std::min(scored_frames, set.size() - first);
    const Frames changes =
        set.voltages(first, count).rowwise() - set.reference_voltages().transpose();
    const Images truths = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    Images images(changes.rows(), sensor.pixels());
    std::vector<FrameReport> reports(count);
    solver.reconstruct(changes, images, reports);
    const std::vector<std::vector<FoundContact>> found = contacts.of(changes, images, reports);
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const bool explains = explained && is_usable(reports[i], images.row(row));
      scoring.add(truths.row(row), images.row(row), scenes[i], reports[i], found[i],
                  explains ? explained->of(changes.row(row), images.row(row)) : std::nullopt);
    }
  }
  return scoring.result();
}

}  // namespace ertbench
