#include <map>
#include <nlohmann/json.hpp>

#include "bench/record/cache.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/score/image_contacts.h"
#include "bench/studies/arm_hour.h"
#include "bench/studies/columns.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/front/quiet_reference.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Raised whenever the same time would be judged otherwise, or the layout changes.
constexpr int arm_schema = 1;
constexpr Eigen::Index hour_block = 256;  ///< frames
constexpr Eigen::Index idle_every = 5;    ///< frame that is reconstructed while nothing happens

using HourColumn = StudyColumn<HourScores>;

StudyColumns<HourScores> hour_columns(const std::string& study) {
  const auto headline = [&](const char* what) {
    return [text = study + ": " + what](const HourScores& one) {
      return text + (one.follows ? ", re-referenced" : "");
    };
  };
  const auto share = [](int missed, int all) {
    return Cell(std::to_string(missed) + " of " + std::to_string(all));
  };
  return {
      HourColumn::words("reference",
                        [](const HourScores& one) { return one.follows ? "re-taken" : "first"; })
          .table("reference"),
      HourColumn::number("touches_missed", &HourScores::touches_missed, 0)
          .table("touches missed")
          .shown([=](const HourScores& one) { return share(one.touches_missed, one.touches); })
          .headline(headline("touches missed"), 0),
      HourColumn::number("touches", &HourScores::touches, 0),
      HourColumn::number("presses_missed", &HourScores::presses_missed, 0)
          .table("presses missed")
          .shown([=](const HourScores& one) { return share(one.presses_missed, one.presses); }),
      HourColumn::number("presses", &HourScores::presses, 0),
      HourColumn::number("presses_seen_share", &HourScores::seen, 3)
          .table("seen, of the presses' time"),
      HourColumn::number("false_alarms", &HourScores::false_alarms, 0),
      HourColumn::number("false_alarms_per_hour", &HourScores::false_alarms_h, 1)
          .table("false alarms an hour")
          .headline(headline("false alarms an hour"), 1),
      HourColumn::number("false_alarm_share", &HourScores::false_share, 3).table("of the time"),
      HourColumn::number("location_error_mm", &HourScores::error_mm, 1)
          .table("localisation error, mm"),
      HourColumn::number("fails_after_min", &HourScores::fails_min, 1).table("fails after, min"),
      HourColumn::number("frames", &HourScores::frames, 0)};
}

HourScores hour_scores_from(const json& object) {
  HourScores out;
  out.follows = object.at("follows").get<bool>();
  const auto read = [&](const char* key, auto& value) { object.at(key).get_to(value); };
  const auto read_some = [&](const char* key, std::optional<double>& value) {
    if (!object.at(key).is_null()) value = object.at(key).get<double>();
  };
  read("frames", out.frames);
  read("touches", out.touches);
  read("touches_missed", out.touches_missed);
  read("presses", out.presses);
  read("presses_missed", out.presses_missed);
  read("presses_seen_share", out.seen);
  read("false_alarms", out.false_alarms);
  read("false_alarms_per_hour", out.false_alarms_h);
  read("false_alarm_share", out.false_share);
  read_some("location_error_mm", out.error_mm);
  read_some("fails_after_min", out.fails_min);
  return out;
}

/// The outcome of a label in a study.
struct HourOutcome {
  std::string failure;  ///< why there are no scores; else empty
  std::vector<HourScores> scores;
};
using HourOutcomes = std::map<std::pair<std::string, std::string>, HourOutcome>;

HourSettings hour_settings(const StudySpec& spec) {
  return {spec.number("minutes"), spec.number("frame_rate"), spec.number("snr_db"),
          static_cast<std::uint64_t>(spec.number("seed"))};
}

std::vector<const StudySpec*> arm_studies(const Experiment& experiment) {
  std::vector<const StudySpec*> out;
  for (const StudySpec& spec : experiment.studies) {
    if (spec.type == "arm_hour") out.push_back(&spec);
  }
  return out;
}

const DatasetSpec* set_chosen_on(const Experiment& experiment) {
  const std::string& other = experiment.contacts.chosen_on;
  return experiment.find_dataset(other.empty() ? "validation" : other);
}

/// A solver and the judge of the contacts that it detects, on frames in blocks.
class HourWatch {
 public:
  HourWatch(const Solver& solver, const Sensor& sensor, const ContactRule& rule,
            const ArmHour& hour, double match_mm)
      : solver_(solver),
        sensor_(sensor),
        rule_(rule),
        reader_(sensor),
        judge_(hour.touches(), match_mm),
        changes_(hour_block, sensor.channels()) {}

  void add(double time_s, const Eigen::RowVectorXd& change) {
    changes_.row(static_cast<Eigen::Index>(times_s_.size())) = change;
    times_s_.push_back(time_s);
    if (static_cast<Eigen::Index>(times_s_.size()) == hour_block) flush();
  }
  HourScores scores(double seconds) {
    flush();
    return judge_.scores(seconds);
  }

 private:
  void flush() {
    const std::size_t count = times_s_.size();
    const auto changes = changes_.topRows(static_cast<Eigen::Index>(count));
    std::vector<std::vector<FoundContact>> found(count);
    if (count > 0) reader_.find(solver_, rule_, changes, found);
    for (std::size_t f = 0; f < count; ++f) {
      judge_.see(times_s_[f], centred_places_mm(found[f], *sensor_.sheet));
    }
    times_s_.clear();
  }

  const Solver& solver_;
  const Sensor& sensor_;
  ContactRule rule_;
  ContactReader reader_;
  HourJudge judge_;
  Frames changes_;
  std::vector<double> times_s_;
};

json watched(const StudySpec& spec, const Solver& solver, const ContactRule& rule,
             const JobContext& context) {
  const Sensor& sensor = context.experiment.sensor;
  const HourSettings settings = hour_settings(spec);
  const ArmHour hour(sensor, settings);
  const double match_mm = context.experiment.contacts.distances(sensor).match;
  HourWatch first(solver, sensor, rule, hour, match_mm);
  HourWatch retaken(solver, sensor, rule, hour, match_mm);
  QuietReference quiet(sensor);
  ProgressFile progress(context.progress_file);
  Eigen::RowVectorXd change(sensor.channels());
  for (Eigen::Index f = 0; f < hour.frames(); ++f) {
    hour.frame(f, change);
    const bool is_seen = f % idle_every == 0 || hour.is_eventful(f);
    if (is_seen) first.add(hour.time_s(f), change);
    quiet.follow(change, hour.time_s(f));
    if (is_seen) retaken.add(hour.time_s(f), change);
    if (f % 6000 == 0) {
      progress.update(static_cast<std::uint64_t>(f), static_cast<std::uint64_t>(hour.frames()), "");
    }
  }
  json out = {{"schema", arm_schema}, {"scores", json::array()}};
  for (HourWatch* watch : {&first, &retaken}) {
    HourScores scores = watch->scores(60 * settings.minutes);
    scores.follows = watch == &retaken;
    out["scores"].push_back(hour_columns(spec.name).json(scores));
    out["scores"].back()["follows"] = scores.follows;
  }
  return out;
}

/// A job for each solver and each study "arm_hour"; its round is the number of the study.
class ArmHourStage final : public Stage {
 public:
  std::string name() const override { return "hours"; }
  std::string noun() const override { return "hour"; }

  std::vector<Job> jobs(const Experiment& experiment) const override {
    std::vector<Job> jobs;
    for (std::size_t s = 0; s < arm_studies(experiment).size(); ++s) {
      for (const std::span<const SolverEntry> entries : experiment.rows()) {
        jobs.push_back(job_of(*this, entries.front(), static_cast<int>(s)));
      }
    }
    return jobs;
  }
  std::string key(const Experiment& experiment, const Job& job) const override {
    const DatasetSpec* chosen = set_chosen_on(experiment);
    const json key = {
        {"schema", arm_schema},
        {"label", job.entry->label},
        {"entry", job.entry->spec.text()},
        {"solver", Cache::fitted_solver_key(fit_recipe(experiment, *job.entry)).dump()},
        {"contacts", to_json(experiment.contacts)},
        {"chosen_on", chosen ? to_json(*chosen) : json()},
        {"numbers", spec_of(experiment, job).numbers}};
    return hash_of(key.dump());
  }
  json run(const Job& job, const JobContext& context) const override {
    const Experiment& experiment = context.experiment;
    const FittedSolver fitted =
        fitted_solver(fit_recipe(experiment, *job.entry), context.cache, context.registry,
                      context.threads, context.progress_file);
    std::optional<DatasetFile> set;
    if (const DatasetSpec* chosen = set_chosen_on(experiment)) {
      set.emplace(context.cache.open_dataset(*chosen));
    }
    const ContactRule rule = choose_contact_rule(experiment.contacts, experiment.sensor,
                                                 *fitted.solver, set ? &*set : nullptr)
                                 .rule;
    return watched(spec_of(experiment, job), *fitted.solver, rule, context);
  }
  void check(const Experiment&, const json& record) const override {
    for (const json& one : record.at("scores")) hour_scores_from(one);
  }
  void collect(const Experiment& experiment, const Cache&, const JobRecords& records,
               ExperimentResults& results) const override {
    for (const Job& job : jobs(experiment)) {
      HourOutcome& outcome =
          results.findings.of<HourOutcomes>()[{spec_of(experiment, job).name, job.entry->label}];
      if (const auto record = records.read(job)) {
        for (const json& one : record->at("scores"))
          outcome.scores.push_back(hour_scores_from(one));
      } else {
        outcome.failure = records.why_missing(job).text();
      }
    }
  }

 private:
  static const StudySpec& spec_of(const Experiment& experiment, const Job& job) {
    return *arm_studies(experiment).at(static_cast<std::size_t>(job.round));
  }
};

}  // namespace

std::unique_ptr<Stage> arm_hour_stage() { return std::make_unique<ArmHourStage>(); }

Study arm_hour_study(const StudyInput& input) {
  const StudyColumns<HourScores> columns = hour_columns(input.spec.name);
  Study study(input.spec.name, "A time on the arm", {{"solvers", json::object()}});
  StudySection& section = study.sections.front();
  section.subject = ": a time on the arm";
  section.report.text =
      "A robot works for " + number_text(input.spec.number("minutes")) +
      " minutes while its skin ages, hums, comes loose and is moved (docs/touch.md). Contacts are "
      "tracks that two of three frames confirm. A touch is missed if no track comes close to it. "
      "A false alarm is a track far from any contact; a pause of a second ends it. A method fails "
      "at the first press that it misses, or the first false alarm that lasts for a second. Each "
      "method runs with the first reference, and with one that is re-taken while nothing presses.";
  section.report.notes = {
      "While nothing happens every fifth frame is reconstructed. Each time is one, drawn from a "
      "seed, and has no interval."};
  TableSection& table = section.report.tables.emplace_back();
  table.columns = columns.titles({{"solver", Align::left}});
  TableSection rows;
  rows.columns = columns.names({{"solver", Align::left}});
  const auto outcomes = input.results.findings.found<HourOutcomes>();
  for (const std::string& label : input.labels()) {
    const auto found = outcomes.find({input.spec.name, label});
    const HourOutcome outcome = found == outcomes.end() ? HourOutcome{} : found->second;
    json& numbers = study.numbers["solvers"][label] = json::array();
    if (outcome.scores.empty()) {
      table.rows.push_back({label, outcome.failure});
      table.rows.back().resize(table.columns.size());
    }
    for (const HourScores& one : outcome.scores) {
      table.rows.push_back(columns.cells({one.follows ? "" : label}, one));
      rows.rows.push_back(columns.data({label}, one));
      columns.add_headlines(label, one, study.best);
      numbers.push_back(columns.json(one));
    }
  }
  section.data = {{"", rows}};
  return study;
}

}  // namespace ertbench
