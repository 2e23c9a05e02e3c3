#include "bench/run/accuracy_stage.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "bench/record/measurement_records.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/run/rows.h"
#include "bench/score/metric_formulas.h"
#include "bench/score/metrics.h"
#include "forward/data/dataset_file.h"
#include "frames/frame_bounds.h"
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
      frames_["readings"].push_back(to_json(reading));
    }
    row_.undefined_frames += !usable;
    row_.frames_not_converged += report.status == FrameStatus::not_converged;
    row_.suspect_frames += usable && report.status == FrameStatus::suspect;
    frames_["status"].push_back(static_cast<int>(usable ? report.status : FrameStatus::undefined));
    frames_["reasons"].push_back(report.reasons);
    frames_["iterations"].push_back(report.iterations);
    frames_["gap"].push_back(report.gap);
    const std::vector<int>& scenes = request_.figure_scenes;
    if (std::ranges::find(scenes, index) != scenes.end()) {
      kept_[index] = std::vector<double>(image.begin(), image.end());
    }
  }

  ScoredFrames result() {
    row_.frames = static_cast<int>(metrics_.size());
    row_.metrics = summarise(metrics_, truth_);
    for (const Metric metric : kMetrics) {
      if (is_known(metric, truth_)) frames_[name_of(metric)] = numbers_or_null(metrics_, metric);
    }
    json images = json::array();
    for (const int scene : request_.figure_scenes) images.push_back(kept_.at(scene));
    return {row_, std::move(frames_), std::move(images)};
  }

 private:
  const Sensor& sensor_;
  const ScoreRequest& request_;
  Truth truth_;
  ResultRow row_;
  std::vector<FrameMetrics> metrics_;
  json frames_;  ///< as in the record
  std::map<int, json> kept_;
};

/// The test sets, and the validation set behind them where sizes are chosen on it.
std::vector<const DatasetSpec*> scored_sets(const Experiment& experiment) {
  std::vector<const DatasetSpec*> sets;
  for (const DatasetSpec& test : experiment.tests) sets.push_back(&test);
  if (experiment.right_sizing) sets.push_back(&*experiment.validation);
  return sets;
}

/// How contacts are read out of this solver's images.
ContactRuleChoice chosen_rule(const Experiment& experiment, const Cache& cache,
                              const Solver& solver) {
  const std::string& other = experiment.contacts.chosen_on;
  const DatasetSpec* spec = experiment.find_dataset(other.empty() ? "validation" : other);
  std::optional<DatasetFile> set;
  if (spec) set.emplace(cache.open_dataset(*spec));
  return choose_contact_rule(experiment.contacts, experiment.sensor, solver, set ? &*set : nullptr);
}

/// Adds what was read out of the images of one of the label's seeds.
void add_readings(const Experiment& experiment, const ScoredTrial& trial,
                  ExperimentResults& results) {
  auto& readings = results.readings[trial.entry->label];
  for (std::size_t set = 0; set < experiment.tests.size(); ++set) {
    readings[experiment.tests[set].name].push_back(trial.accuracy->sets.at(set).readings);
  }
}

/// What each trial that was scored gave for each frame.
void add_frames(const Experiment& experiment, const std::vector<ScoredTrial>& trials,
                ExperimentResults& results) {
  results.frames.resize(experiment.tests.size());
  for (std::size_t set = 0; set < experiment.tests.size(); ++set) {
    ScoredLabels& scored = results.frames[set];
    scored.dataset = experiment.tests[set].name;
    FramesOfSeeds frames;
    for (const ScoredTrial& trial : trials) {
      if (trial.accuracy) frames.push_back(trial.accuracy->sets.at(set).frames);
    }
    if (frames.empty()) continue;
    scored.labels.push_back(trials.front().entry->label);
    scored.frames.push_back(std::move(frames));
  }
}

class AccuracyStage final : public Stage {
 public:
  std::string name() const override { return "accuracy"; }
  std::string key(const Experiment& experiment, const Job& job) const override {
    return accuracy_key(experiment, *job.entry);
  }
  json run(const Job& job, const JobContext& context) const override {
    const Experiment& experiment = context.experiment;
    const FittedSolver fitted =
        fitted_solver(fit_recipe(experiment, *job.entry), context.cache, context.registry,
                      context.threads, context.progress_file);
    const FitReport report = fitted.solver->fit_report();
    json record = {{"schema", record_schema},
                   {"fit_s", fitted.fit_s ? json(*fitted.fit_s) : json()},
                   {"fit_build", to_json(*fitted.build)},
                   {"fit_report", {{"status", report.status}, {"message", report.message}}}};
    json parameters = fitted.solver->parameters();
    if (!report.frame_check.empty()) parameters["frame_check"] = report.frame_check;
    ScoreRequest request{experiment.figure_scenes, experiment.contacts.rule(),
                         experiment.contacts.distances(experiment.sensor), experiment.keep_contacts,
                         experiment.keep_explained};
    if (!fitted.solver->contact_finder()) {
      const ContactRuleChoice choice = chosen_rule(experiment, context.cache, *fitted.solver);
      request.rule = choice.rule;
      parameters["contacts"] = to_json(choice);
    }
    const std::vector<const DatasetSpec*> sets = scored_sets(experiment);
    for (const DatasetSpec* spec : sets) {
      const bool first = spec == sets.front();
      if (!first) request.figure_scenes.clear();
      request.judge_frames = spec->measured() != nullptr;
      ScoredFrames scored =
          score_set(*fitted.solver, context.cache.open_dataset(*spec), experiment.sensor, request);
      ResultRow& row = scored.row;
      row.label = job.entry->label;
      row.type = job.entry->type;
      row.dataset = spec->name;
      row.status = report.status;
      row.message = report.message;
      row.parameters = parameters;
      row.fit_s = fitted.fit_s;
      record["rows"].push_back(to_json(row));
      record["frames"][spec->name] = *scored.frames;
      if (first) record["figure_images"] = *scored.figure_images;
    }
    return record;
  }
  void check(const Experiment& experiment, const json& record) const override {
    accuracy_record_from_json(record, experiment, "");
  }
  void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
               ExperimentResults& results) const override {
    results.rows = reference_rows(experiment.sensor, experiment.tests, experiment.contacts, cache);
    for (const std::span<const SolverEntry> entries : experiment.rows()) {
      std::vector<ScoredTrial> trials;
      LabelOutcome& label = results.labels[entries.front().label];
      for (const SolverEntry& entry : entries) {
        const Job job = job_of(*this, entry);
        ScoredTrial& trial = trials.emplace_back();
        trial.entry = &entry;
        trial.failure = records.why_missing(job);
        const std::optional<json> record = records.read(job);
        if (!record) continue;
        trial.accuracy = accuracy_record_from_json(*record, experiment, records.file(job).string());
        if (!label.scored) label.scored = &entry;
        results.images.emplace(entry.label, trial.accuracy->figure_images);  // the first seed's
        if (experiment.keep_contacts) add_readings(experiment, trial, results);
        results.training[entry.label].push_back(
            {entry.stem(), entry.seed ? "seed " + std::to_string(*entry.seed) : "",
             cache.work_folder(fit_recipe(experiment, entry)) / "training.csv",
             trial.accuracy->sets.front().row.parameters});
      }
      if (!label.scored) label.failure = trials.front().failure.text();
      add_frames(experiment, trials, results);
      const std::vector<ResultRow> rows = rows_of(experiment.tests, trials);
      results.rows.insert(results.rows.end(), rows.begin(), rows.end());
    }
    // Test set by test set, each beginning with its truth.
    std::ranges::stable_sort(results.rows, {}, [&](const ResultRow& row) {
      return experiment.find_dataset(row.dataset);
    });
  }
  void forget(const Experiment& experiment, const Cache& cache, const Job& job) const override {
    forget_fitted_solver(fit_recipe(experiment, *job.entry), cache);
  }
};

}  // namespace

ScoredFrames score_set(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
                       const ScoreRequest& request) {
  Scoring scoring(sensor, request, set.truth());
  std::optional<FrameBounds> bounds;
  if (request.judge_frames) bounds.emplace(sensor);
  const Eigen::RowVectorXd reference = set.reference_voltages().transpose();
  std::optional<ExplainedChange> explained;
  if (request.keep_explained) explained.emplace(sensor, set.reference_voltages());
  Reconstruction reconstruction(sensor, solver, request.rule);
  for (std::uint64_t first = 0; first < set.size(); first += scored_frames) {
    const std::uint64_t count = std::min(scored_frames, set.size() - first);
    const Frames changes = set.voltages(first, count).rowwise() - reference;
    const Images truths = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    Answers answers(count, sensor.pixels());
    reconstruction.ask(changes, set.sequences(first, count), answers);
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto image = answers.images.row(row);
      FrameReport& said = answers.reports[i];
      if (bounds) report(bounds->judge(changes.row(row), reference, said), said);
      const bool explains = explained && is_usable(said, image);
      scoring.add(truths.row(row), image, scenes[i], said, answers.contacts[i],
                  explains ? explained->of(changes.row(row), image) : std::nullopt);
    }
  }
  return scoring.result();
}

std::unique_ptr<Stage> accuracy_stage() { return std::make_unique<AccuracyStage>(); }

}  // namespace ertbench
