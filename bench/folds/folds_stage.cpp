#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bench/features/parts.h"
#include "bench/folds/presses.h"
#include "bench/record/cache.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/run/stage.h"
#include "bench/score/image_contacts.h"
#include "bench/studies/arm_hour.h"
#include "bench/studies/study.h"
#include "core/errors.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Raised whenever the same presses would be read otherwise, or the layout changes.
constexpr int folds_schema = 1;

json press_json(const HeldOutPress& press) {
  json out = {press.place_mm.x(), press.place_mm.y(), press.strength, nullptr, nullptr, 0};
  if (press.found_mm) {
    out[3] = press.found_mm->x();
    out[4] = press.found_mm->y();
    out[5] = press.found_strength;
  }
  return out;
}

HeldOutPress press_from(const json& values) {
  HeldOutPress out;
  out.place_mm = {values.at(0).get<double>(), values.at(1).get<double>()};
  out.strength = values.at(2).get<double>();
  if (!values.at(3).is_null()) {
    out.found_mm = Eigen::Vector2d(values.at(3).get<double>(), values.at(4).get<double>());
  }
  out.found_strength = values.at(5).get<double>();
  return out;
}

std::vector<HeldOutPress> held_out_presses(const Solver& solver, const DatasetFile& set,
                                           const ContactRule& rule) {
  const double mm = set.sensor().sheet->unit_mm();
  const std::vector<Scene> scenes = set.scenes(0, set.size());
  const Frames changes =
      set.voltages(0, set.size()).rowwise() - set.reference_voltages().transpose();
  std::vector<std::vector<FoundContact>> found(set.size());
  ContactReader(set.sensor()).find(solver, rule, changes, found);
  std::vector<HeldOutPress> out;
  for (std::size_t f = 0; f < scenes.size(); ++f) {
    if (scenes[f].contacts.size() != 1) continue;  // a study of single presses
    const Contact& contact = scenes[f].contacts.front();
    HeldOutPress& press = out.emplace_back();
    press.place_mm = contact.centroid() * mm;
    press.strength = 1 - contact.conductivity_ratio;
    if (found[f].empty() || !found[f].front().place.allFinite()) continue;
    const double whole = std::numbers::pi * contact.half_size.prod() * set.sensor().background;
    press.found_mm = found[f].front().place * mm;
    press.found_strength = std::copysign(found[f].front().strength / whole, press.strength);
  }
  return out;
}

FoldRun run_of(const Folds& folds, int fold, std::uint64_t presses, const SolverEntry& entry,
               const JobContext& context) {
  const Experiment& experiment = context.experiment;
  FoldRun run;
  run.presses = presses;
  FitRecipe recipe = fit_recipe(experiment, entry);
  recipe.sensor = folds.skin_of(fold).sensor;
  recipe.training = folds.training(fold, presses);
  recipe.validation = folds.validation_set(fold, presses);
  const DatasetSpec test = folds.test(fold);
  for (const DatasetSpec& spec : {*recipe.training, *recipe.validation, test}) {
    ensure_dataset(spec, context.cache, context.threads);
  }
  try {
    const FittedSolver fitted = fitted_solver(recipe, context.cache, context.registry,
                                              context.threads, context.progress_file);
    run.fit_s = fitted.fit_s.value_or(0);
    ContactRule rule = experiment.contacts.rule();
    if (!fitted.solver->contact_finder()) {
      const DatasetFile validation = context.cache.open_dataset(*recipe.validation);
      rule =
          choose_contact_rule(experiment.contacts, recipe.sensor, *fitted.solver, &validation).rule;
    }
    run.held_out = held_out_presses(*fitted.solver, context.cache.open_dataset(test), rule);
  } catch (const InputError& wrong) {
    run.message = wrong.what();
  }
  return run;
}

/// Cross-validation on measured frames (Folds), a job for each solver and fold. A study
/// (bench/studies) is made of what comes out.
class FoldsStage final : public Stage {
 public:
  std::string name() const override { return "folds"; }
  std::string noun() const override { return "fold"; }

  std::vector<Job> jobs(const Experiment& experiment) const override {
    std::vector<Job> jobs;
    if (!experiment.folds) return jobs;
    for (const std::span<const SolverEntry> entries : experiment.rows()) {
      for (int fold = 0; fold < experiment.folds->total(); ++fold) {
        jobs.push_back(job_of(*this, entries.front(), fold));
      }
    }
    return jobs;
  }
  std::string key(const Experiment& experiment, const Job& job) const override {
    FitRecipe own = fit_recipe(experiment, *job.entry);
    own.training.reset();
    own.validation.reset();
    const json key = {{"schema", folds_schema},
                      {"label", own.entry.label},
                      {"entry", own.entry.spec.text()},
                      {"solver", Cache::fitted_solver_key(own).dump()},
                      {"folds", to_json(*experiment.folds)},
                      {"contacts", to_json(experiment.contacts)},
                      {"fold", job.round}};
    return hash_of(key.dump());
  }
  json run(const Job& job, const JobContext& context) const override {
    const Folds& folds = *context.experiment.folds;
    FoldRecord record;
    for (const std::uint64_t presses : folds.presses) {
      if (presses > folds.most(folds.skin_of(job.round))) break;  // they ascend
      record.push_back(run_of(folds, job.round, presses, *job.entry, context));
    }
    return to_json(record);
  }
  void check(const Experiment&, const json& record) const override {
    fold_record_from_json(record);
  }
  void collect(const Experiment& experiment, const Cache&, const JobRecords& records,
               ExperimentResults& results) const override {
    if (!experiment.folds) return;
    std::vector<FoldsOutcome> outcomes;
    for (const Job& job : jobs(experiment)) {
      if (job.round == 0) outcomes.emplace_back().label = job.entry->label;
      FoldsOutcome& outcome = outcomes.back();
      outcome.folds.emplace_back();
      if (const auto record = records.read(job)) {
        outcome.folds.back() = fold_record_from_json(*record);
      } else if (outcome.failure.empty()) {
        outcome.failure = records.why_missing(job).text();
      }
    }
    const auto study = std::make_shared<const Study>(presses_study(*experiment.folds, outcomes));
    results.studies.push_back({"presses", "presses", study->numbers, study});
  }
};

}  // namespace

json to_json(const FoldRecord& record) {
  json out = {{"schema", folds_schema}, {"runs", json::array()}};
  for (const FoldRun& run : record) {
    json one = {{"presses", run.presses},
                {"message", run.message},
                {"fit_s", run.fit_s},
                {"held_out", json::array()}};
    for (const HeldOutPress& press : run.held_out) one["held_out"].push_back(press_json(press));
    out["runs"].push_back(std::move(one));
  }
  return out;
}

FoldRecord fold_record_from_json(const json& object) {
  FoldRecord record;
  for (const json& one : object.at("runs")) {
    FoldRun& run = record.emplace_back();
    run.presses = one.at("presses").get<std::uint64_t>();
    run.message = one.at("message").get<std::string>();
    run.fit_s = one.at("fit_s").get<double>();
    for (const json& press : one.at("held_out")) run.held_out.push_back(press_from(press));
  }
  return record;
}

}  // namespace ertbench

extern "C" void ertbench_part_studies(ertbench::Part& part) {
  part.stages = [](int) {
    ertbench::Stages stages;
    stages.push_back(std::make_unique<ertbench::FoldsStage>());
    stages.push_back(ertbench::arm_hour_stage());
    stages.push_back(ertbench::study_stage());
    return stages;
  };
}
