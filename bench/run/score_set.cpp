#include "bench/run/score_set.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
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

/// What a solver makes of some frames.
struct Answers {
  Answers(std::size_t frames, int pixels)
      : images(static_cast<Eigen::Index>(frames), pixels), reports(frames), contacts(frames) {}
  Images images;
  std::vector<FrameReport> reports;
  std::vector<std::vector<FoundContact>> contacts;
};

/// Asks a solver for the frames of a set in their order: for many at a time where each stands
/// alone, and one by one, in a stream for each sequence, where they move. Contacts are those that
/// the solver knows, else those that the rule reads out of its images.
class Reconstruction {
 public:
  Reconstruction(const Sensor& sensor, const Solver& solver, const ContactRule& rule)
      : solver_(solver), finder_(solver.contact_finder()), rule_(rule), reader_(sensor) {}

  /// `sequences` [frames]: of which sequence each is; empty where they do not move.
  void ask(const Frames& changes, const Eigen::VectorXd& sequences, Answers& out) {
    if (sequences.size() == 0) {
      solver_.reconstruct(changes, out.images, out.reports);
      if (finder_) finder_->find_contacts(changes, out.contacts);
    }
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const bool known = sequences.size() > 0 && follow(changes, sequences[f], f, out);
      const auto i = static_cast<std::size_t>(f);
      if (!known && !finder_ && is_usable(out.reports[i], out.images.row(f))) {
        reader_.read(rule_, out.images.row(f), out.contacts[i]);
      }
      // A contact that is nowhere is none.
      std::erase_if(out.contacts[i], std::not_fn(is_finite));
    }
  }

 private:
  /// The next frame of a sequence; whether its stream knows the contacts.
  bool follow(const Frames& changes, double sequence, Eigen::Index f, Answers& out) {
    if (!stream_ || sequence != sequence_) {
      stream_ = solver_.open_stream();
      sequence_ = sequence;
    }
    const auto i = static_cast<std::size_t>(f);
    const std::vector<FoundContact>* known = nullptr;
    if (stream_) {
      stream_->reconstruct(changes.row(f), out.images.row(f), {&out.reports[i], 1});
      known = stream_->contacts();
    } else {
      solver_.reconstruct(changes.row(f), out.images.row(f), {&out.reports[i], 1});
    }
    if (known) {
      out.contacts[i] = *known;
    } else if (finder_) {
      finder_->find_contacts(changes.row(f), {&out.contacts[i], 1});
    }
    return known != nullptr;
  }

  const Solver& solver_;
  const ContactFinder* finder_;
  ContactRule rule_;
  ContactReader reader_;
  std::unique_ptr<FrameStream> stream_;
  double sequence_ = 0;  ///< of the stream
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
  Reconstruction reconstruction(sensor, solver, request.rule);
  for (std::uint64_t first = 0; first < set.size(); first += scored_frames) {
    const std::uint64_t count = std::min(scored_frames, set.size() - first);
    const Frames changes =
        set.voltages(first, count).rowwise() - set.reference_voltages().transpose();
    const Images truths = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    Answers answers(count, sensor.pixels());
    reconstruction.ask(changes, set.sequences(first, count), answers);
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto image = answers.images.row(row);
      const bool explains = explained && is_usable(answers.reports[i], image);
      scoring.add(truths.row(row), image, scenes[i], answers.reports[i], answers.contacts[i],
                  explains ? explained->of(changes.row(row), image) : std::nullopt);
    }
  }
  return scoring.result();
}

}  // namespace ertbench
