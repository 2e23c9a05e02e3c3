#include "bench/studies/study.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/report/report.h"
#include "bench/studies/collision.h"
#include "bench/studies/consistency.h"
#include "bench/studies/localisation.h"
#include "bench/studies/sensitivity.h"
#include "bench/studies/targets.h"
#include "bench/studies/tracking.h"
#include "bench/table/table.h"
#include "core/files.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {

std::string force_text(const std::pair<double, double>& force_N) {
  const std::string low = number_text(force_N.first);
  return (force_N.first == force_N.second ? low : low + " to " + number_text(force_N.second)) +
         " N";
}

std::string noise_text(const Noise& noise) {
  if (!noise.snr_db) return "no noise";
  return number_text(*noise.snr_db) + " dB " + name_of(noise.basis);
}

std::string without_law(const std::string& title) {
  for (const std::string end : {", rising law", ", falling law"}) {
    if (title.ends_with(end)) return title.substr(0, title.size() - end.size());
  }
  return title;
}

void write_study_tables(const Table& table, const TableSection& rows,
                        const std::filesystem::path& folder, const std::string& name) {
  write_file_atomically(folder / (name + ".md"), markdown_of(table));
  write_file_atomically(folder / (name + ".csv"), csv_of(rows));
}

std::vector<Cell> exact_cells(const std::optional<Estimate>& estimate) {
  if (!estimate) return std::vector<Cell>(3);
  return {exact_cell(estimate->value), exact_cell(estimate->ci95.low),
          exact_cell(estimate->ci95.high)};
}

std::vector<Column> exact_columns(const std::string& name) {
  return {name, name + "_low", name + "_high"};
}

namespace {

/// Trainings of a solver that were scored on all sets.
std::size_t trainings_of(const ExperimentResults& results, const std::string& label) {
  const auto found = results.readings.find(label);
  if (found == results.readings.end() || found->second.empty()) return 0;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const auto& [set, readings] : found->second) least = std::min(least, readings.size());
  return least;
}

std::shared_ptr<const StudyResult> study_of_training(const StudyInput& input) {
  const std::string& type = input.spec.type;
  if (type == "localisation") return std::make_shared<const Localisation>(input);
  if (type == "sensitivity") return std::make_shared<const Sensitivity>(input);
  if (type == "targets") return std::make_shared<const Targets>(input);
  if (type == "tracking") return std::make_shared<const Tracking>(input);
  if (type == "collision") return std::make_shared<const Collision>(input);
  if (type == "consistency") return std::make_shared<const Consistency>(input);
  throw std::logic_error("no study is called " + type);
}

}  // namespace

std::vector<std::string> StudyInput::labels() const {
  std::vector<std::string> out;
  for (const auto entries : experiment.rows()) {
    const std::string& label = entries.front().label;
    if (training == 0 || trainings_of(results, label) > training) out.push_back(label);
  }
  return out;
}

std::size_t StudyInput::trainings() const {
  std::size_t most = 1;
  for (const auto& [label, sets] : results.readings) {
    most = std::max(most, trainings_of(results, label));
  }
  return most;
}

const DatasetSpec& StudyInput::set_spec(const std::string& set) const {
  return *experiment.find_dataset(set);
}

DatasetFile StudyInput::open(const std::string& set) const {
  return cache.open_dataset(set_spec(set));
}

const std::vector<FrameReading>* StudyInput::readings(const std::string& label,
                                                      const std::string& set) const {
  const auto found = results.readings.find(label);
  if (found == results.readings.end()) return nullptr;
  const auto frames = found->second.find(set);
  if (frames == found->second.end() || frames->second.size() <= training) return nullptr;
  return &frames->second[training];
}

std::string StudyInput::failure(const std::string& label) const {
  const auto found = results.labels.find(label);
  return found == results.labels.end() ? "not run" : found->second.failure;
}

std::optional<StudyInput::Latency> StudyInput::latency(const std::string& label) const {
  for (const ResultRow& row : results.rows) {
    if (row.label != label || !row.latency_us) continue;
    return Latency{row.latency_us->p50 * 1e-6, row.latency_us->p99 * 1e-6};
  }
  return std::nullopt;
}

std::string StudyInput::law() const { return name_of(experiment.sensor.skin->law); }

std::shared_ptr<const StudyResult> make_study(const StudyInput& input) {
  std::shared_ptr<const StudyResult> first = study_of_training(input);
  std::vector<std::vector<Headline>> of_trainings = {first->headlines()};
  for (std::size_t training = 1; training < input.trainings(); ++training) {
    StudyInput again = input;
    again.training = training;
    of_trainings.push_back(study_of_training(again)->headlines());
  }
  if (of_trainings.size() == 1) return first;
  return std::make_shared<const StudyTrainings>(input.spec.name, std::move(first),
                                                spread_of(of_trainings));
}

namespace {

using nlohmann::json;

std::vector<double> defined(const std::vector<std::optional<double>>& values) {
  std::vector<double> out;
  for (const std::optional<double>& value : values) {
    if (value) out.push_back(*value);
  }
  return out;
}

json json_of(const std::optional<double>& value) { return value ? json(*value) : json(); }

std::size_t most_trainings(const std::vector<HeadlineSpread>& spread) {
  std::size_t most = 0;
  for (const HeadlineSpread& one : spread) most = std::max(most, one.values.size());
  return most;
}

TableSection table_of(const std::vector<HeadlineSpread>& spread) {
  TableSection table;
  table.columns = {{"solver", Align::left}, {"number", Align::left}, {"mean"}, {"deviation"}};
  const std::size_t trainings = most_trainings(spread);
  for (std::size_t t = 0; t < trainings; ++t) {
    table.columns.push_back("training " + std::to_string(t + 1));
  }
  std::string before;
  for (const HeadlineSpread& one : spread) {
    std::vector<Cell> row = {one.label == before ? "" : one.label, one.what,
                             number_cell(one.mean(), one.decimals),
                             number_cell(one.deviation(), one.decimals)};
    before = one.label;
    for (std::size_t t = 0; t < trainings; ++t) {
      row.push_back(t < one.values.size() ? number_cell(one.values[t], one.decimals) : Cell());
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// A row a training, for programs.
TableSection rows_of(const std::vector<HeadlineSpread>& spread) {
  TableSection rows;
  rows.columns = {{"solver", Align::left}, {"what", Align::left}, {"training"}, {"value"}};
  for (const HeadlineSpread& one : spread) {
    for (std::size_t t = 0; t < one.values.size(); ++t) {
      rows.rows.push_back({one.label, one.what, std::to_string(t + 1), exact_cell(one.values[t])});
    }
  }
  return rows;
}

}  // namespace

std::optional<double> HeadlineSpread::mean() const {
  const std::vector<double> found = defined(values);
  return found.empty() ? std::nullopt : std::optional(ertbench::mean(found));
}

std::optional<double> HeadlineSpread::deviation() const {
  const std::vector<double> found = defined(values);
  return found.size() < 2 ? std::nullopt : std::optional(sample_deviation(found));
}

std::vector<HeadlineSpread> spread_of(std::span<const std::vector<Headline>> of_trainings) {
  std::vector<HeadlineSpread> out;
  for (const Headline& first : of_trainings.front()) {
    HeadlineSpread spread{first.label, first.what, first.decimals, {first.value}};
    for (const std::vector<Headline>& training : of_trainings.subspan(1)) {
      const auto found =
          std::find_if(training.begin(), training.end(), [&](const Headline& headline) {
            return headline.label == first.label && headline.what == first.what;
          });
      if (found != training.end()) spread.values.push_back(found->value);
    }
    if (spread.values.size() > 1) out.push_back(std::move(spread));
  }
  // A study tells set by set; here a solver's numbers stand together.
  std::vector<std::string> labels;
  for (const HeadlineSpread& one : out) {
    if (std::find(labels.begin(), labels.end(), one.label) == labels.end()) {
      labels.push_back(one.label);
    }
  }
  const auto place = [&](const HeadlineSpread& one) {
    return std::find(labels.begin(), labels.end(), one.label) - labels.begin();
  };
  std::stable_sort(out.begin(), out.end(), [&](const HeadlineSpread& a, const HeadlineSpread& b) {
    return place(a) < place(b);
  });
  return out;
}

json StudyTrainings::summary() const {
  json out = first_->summary();
  json& trainings = out["trainings"] = json::array();
  for (const HeadlineSpread& one : spread_) {
    json values = json::array();
    for (const std::optional<double>& value : one.values) values.push_back(json_of(value));
    trainings.push_back({{"solver", one.label},
                         {"what", one.what},
                         {"values", values},
                         {"mean", json_of(one.mean())},
                         {"deviation", json_of(one.deviation())}});
  }
  return out;
}

std::vector<ReportSection> StudyTrainings::report(const std::string& title,
                                                  const std::filesystem::path& folder) const {
  std::vector<ReportSection> sections = first_->report(title, folder);
  ReportSection section;
  section.title = name_ + ": what another training changes";
  section.text =
      "The study's own tables and figures are of the first training of each solver. Here are its "
      "headline numbers of all trainings, which differ by their seed alone: their mean, their "
      "sample standard deviation, and each. Two solvers whose numbers differ by less than a few "
      "deviations are told apart by the trainings' luck.";
  section.tables = {table_of(spread_)};
  section.collapsed = true;
  write_study_tables({title + ", by training", section.text, section.tables, {}, {}},
                     rows_of(spread_), folder, name_ + "_trainings");
  sections.push_back(std::move(section));
  return sections;
}

std::string StudyStage::name() const { return "studies"; }

std::string StudyStage::noun() const { return "study"; }

std::vector<Job> StudyStage::jobs(const Experiment&) const { return {}; }

std::vector<Job> StudyStage::due(const Experiment&, const ExperimentResults&) const { return {}; }

std::string StudyStage::key(const Experiment&, const Job&) const {
  throw std::logic_error("studies have no jobs");
}

nlohmann::json StudyStage::run(const Job&, const JobContext&) const {
  throw std::logic_error("studies have no jobs");
}

void StudyStage::check(const Experiment&, const nlohmann::json&) const {
  throw std::logic_error("studies have no records");
}

void StudyStage::collect(const Experiment& experiment, const Cache& cache, const JobRecords&,
                         ExperimentResults& results) const {
  for (const StudySpec& spec : experiment.studies) {
    results.studies.push_back(
        {spec.name, spec.type, make_study({spec, experiment, results, cache})});
  }
}

std::vector<ReportSection> StudyStage::report(const Experiment& experiment,
                                              const ExperimentResults& results,
                                              const std::filesystem::path& folder) const {
  std::vector<ReportSection> sections;
  for (const StudyOutcome& study : results.studies) {
    for (ReportSection& section : study.result->report(experiment.title, folder)) {
      sections.push_back(std::move(section));
    }
  }
  return sections;
}

}  // namespace ertbench
