#include "bench/run/accuracy_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/contacts/contact_rule_choice.h"
#include "bench/record/accuracy_record.h"
#include "bench/record/record_file.h"
#include "bench/run/fitted_solver.h"
#include "bench/run/job_records.h"
#include "bench/run/reference_rows.h"
#include "bench/run/rows.h"
#include "bench/run/score_set.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// The test sets, and the validation set behind them where sizes are chosen on it.
std::vector<const DatasetSpec*> scored_sets(const Experiment& experiment) {
  std::vector<const DatasetSpec*> sets;
  for (const DatasetSpec& test : experiment.tests) sets.push_back(&test);
  if (experiment.right_sizing) sets.push_back(&*experiment.validation);
  return sets;
}

AccuracyRecord record_from(const Experiment& experiment, const json& record,
                           const std::string& source) {
  return accuracy_record_from_json(record, experiment.right_sizing.has_value(),
                                   experiment.sensor.pixels(), source);
}

/// Test set by test set, each beginning with its truth.
void sort_by_dataset(const Experiment& experiment, std::vector<ResultRow>& rows) {
  const auto place = [&](const ResultRow& row) { return experiment.find_dataset(row.dataset); };
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const ResultRow& a, const ResultRow& b) { return place(a) < place(b); });
}

TrainingSource training_source(const Experiment& experiment, const Cache& cache,
                               const SolverEntry& entry, const AccuracyRecord& accuracy) {
  return {entry.stem(), entry.seed ? "seed " + std::to_string(*entry.seed) : "",
          cache.work_folder(fit_recipe(experiment, entry)) / "training.csv",
          accuracy.sets.front().row.parameters};
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

}  // namespace

std::string AccuracyStage::name() const { return "accuracy"; }

std::string AccuracyStage::noun() const { return "trial"; }

std::vector<Job> AccuracyStage::jobs(const Experiment& experiment) const {
  std::vector<Job> jobs;
  for (const SolverEntry& entry : experiment.solvers) jobs.push_back(job_of(*this, entry));
  return jobs;
}

std::vector<Job> AccuracyStage::due(const Experiment& experiment, const ExperimentResults&) const {
  return jobs(experiment);
}

std::string AccuracyStage::key(const Experiment& experiment, const Job& job) const {
  return accuracy_key(fit_recipe(experiment, *job.entry), experiment.tests,
                      {experiment.right_sizing.has_value(), experiment.figure_scenes,
                       experiment.contacts, experiment.keep_contacts, experiment.keep_explained});
}

json AccuracyStage::run(const Job& job, const JobContext& context) const {
  const Experiment& experiment = context.experiment;
  const FittedSolver fitted =
      fitted_solver(fit_recipe(experiment, *job.entry), context.cache, context.registry,
                    context.threads, context.progress_file);
  const FitReport report = fitted.solver->fit_report();
  json record = {{"schema", record_schema},
                 {"fit_s", fitted.fit_s},
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

void AccuracyStage::check(const Experiment& experiment, const json& record) const {
  record_from(experiment, record, "");
}

void AccuracyStage::collect(const Experiment& experiment, const Cache& cache,
                            const JobRecords& records, ExperimentResults& results) const {
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
      trial.accuracy = record_from(experiment, *record, records.file(job).string());
      if (!label.scored) label.scored = &entry;
      results.images.emplace(entry.label, trial.accuracy->figure_images);  // the first seed's
      if (experiment.keep_contacts) add_readings(experiment, trial, results);
      results.training[entry.label].push_back(
          training_source(experiment, cache, entry, *trial.accuracy));
    }
    if (!label.scored) label.failure = trials.front().failure.text();
    add_frames(experiment, trials, results);
    const std::vector<ResultRow> rows = rows_of(experiment.tests, trials);
    results.rows.insert(results.rows.end(), rows.begin(), rows.end());
  }
  sort_by_dataset(experiment, results.rows);
}

void AccuracyStage::forget(const Experiment& experiment, const Cache& cache, const Job& job) const {
  forget_fitted_solver(fit_recipe(experiment, *job.entry), cache);
}

}  // namespace ertbench
