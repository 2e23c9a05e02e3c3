#include "bench/studies/study.h"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

#include "bench/plot/canvas.h"
#include "bench/run/rows.h"
#include "bench/studies/arm_hour.h"
#include "bench/studies/collision.h"
#include "bench/studies/columns.h"
#include "bench/studies/consistency.h"
#include "bench/studies/localisation.h"
#include "bench/studies/sensitivity.h"
#include "bench/studies/targets.h"
#include "bench/studies/tracking.h"
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

Study::Study(std::string its_name, std::string title, nlohmann::json its_numbers)
    : name(std::move(its_name)), numbers(std::move(its_numbers)), sections(1) {
  sections.front().report.title = std::move(title);
}

std::vector<ReportSection> Study::report(const std::string& title,
                                         const std::filesystem::path& folder) const {
  std::vector<ReportSection> out;
  for (const StudySection& section : sections) {
    ReportSection& shown = out.emplace_back(section.report);
    for (const StudyFigure& figure : section.figures) {
      const std::filesystem::path stem = folder / (name + figure.part);
      const bool drawn =
          draw_or_say(stem, [&] { figure.draw(without_law(title) + figure.heading, stem); });
      shown.figures.push_back({figure.title, stem.string() + ".svg", figure.caption, drawn});
    }
    const std::filesystem::path files = folder / (name + section.part);
    const Table table{title + section.subject, shown.text, shown.tables, shown.notes, {}};
    write_file_atomically(files.string() + ".md", markdown_of(table));
    for (const auto& [part, rows] : section.data) {
      write_file_atomically(files.string() + part + ".csv", csv_of(rows));
    }
  }
  return out;
}

namespace {

using nlohmann::json;

/// Trainings of a solver that were scored on all sets.
std::size_t trainings_of(const ExperimentResults& results, const std::string& label) {
  const auto found = results.readings.find(label);
  if (found == results.readings.end() || found->second.empty()) return 0;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const auto& [set, readings] : found->second) least = std::min(least, readings.size());
  return least;
}

/// Every type of study (StudySpec::type).
const std::map<std::string, Study (*)(const StudyInput&)> studies = {
    {"localisation", localisation_study}, {"sensitivity", sensitivity_study},
    {"targets", targets_study},           {"tracking", tracking_study},
    {"collision", collision_study},       {"consistency", consistency_study},
    {"arm_hour", arm_hour_study}};

using SpreadColumn = StudyColumn<HeadlineSpread>;

/// The numbers differ in their decimals, so that tables make their own cells.
StudyColumns<HeadlineSpread> spread_columns(const std::vector<HeadlineSpread>& spread) {
  const auto cell_of = [](auto value) {
    return [value](const HeadlineSpread& one) { return number_cell(value(one), one.decimals); };
  };
  const auto mean = [](const HeadlineSpread& one) { return mean_of(one.values); };
  const auto deviation = [](const HeadlineSpread& one) { return deviation_of(one.values); };
  StudyColumns<HeadlineSpread> out = {
      SpreadColumn::words("solver", &HeadlineSpread::label),
      SpreadColumn::words("what", &HeadlineSpread::what).table("number"),
      SpreadColumn::number("mean", mean, 2).table("mean").shown(cell_of(mean)),
      SpreadColumn::number("deviation", deviation, 2).table("deviation").shown(cell_of(deviation))};
  std::size_t trainings = 0;
  for (const HeadlineSpread& one : spread) trainings = std::max(trainings, one.values.size());
  for (std::size_t t = 0; t < trainings; ++t) {
    out.add(SpreadColumn::cell("training " + std::to_string(t + 1), [t](const HeadlineSpread& one) {
      return t < one.values.size() ? number_cell(one.values[t], one.decimals) : Cell();
    }));
  }
  return out;
}

/// Adds what the trainings make of the headlines to the study of the first.
void add_trainings(const std::vector<HeadlineSpread>& spread, Study& study) {
  const StudyColumns<HeadlineSpread> columns = spread_columns(spread);
  StudySection section;
  section.part = "_trainings";
  section.subject = ", by training";
  section.report.title = study.name + ": what another training changes";
  section.report.text =
      "The study's own tables and figures are of the first training of each solver. Here are its "
      "headline numbers of all trainings, which differ by their seed alone: their mean, their "
      "sample standard deviation, and each. Two solvers whose numbers differ by less than a few "
      "deviations do not differ significantly.";
  section.report.collapsed = true;
  TableSection& table = section.report.tables.emplace_back();
  table.columns = columns.titles({{"solver", Align::left}});
  TableSection rows;  // a row a training
  rows.columns = {{"solver", Align::left}, {"what", Align::left}, {"training"}, {"value"}};
  json& trainings = study.numbers["trainings"] = json::array();
  std::string before;
  for (const HeadlineSpread& one : spread) {
    table.rows.push_back(columns.cells({one.label == before ? "" : one.label}, one));
    before = one.label;
    json& all = trainings.emplace_back(columns.json(one));
    all["values"] = json::array();
    for (std::size_t t = 0; t < one.values.size(); ++t) {
      all["values"].push_back(to_json(one.values[t]));
      rows.rows.push_back({one.label, one.what, std::to_string(t + 1), exact_cell(one.values[t])});
    }
  }
  section.data = {{"", rows}};
  study.sections.push_back(std::move(section));
}

class StudyStage final : public Stage {
 public:
  std::string name() const override { return "studies"; }
  std::string noun() const override { return "study"; }
  std::vector<Job> jobs(const Experiment&) const override { return {}; }
  std::string key(const Experiment&, const Job&) const override { throw no_jobs(); }
  json run(const Job&, const JobContext&) const override { throw no_jobs(); }
  void check(const Experiment&, const json&) const override { throw no_jobs(); }

  void collect(const Experiment& experiment, const Cache& cache, const JobRecords&,
               ExperimentResults& results) const override {
    for (const StudySpec& spec : experiment.studies) {
      const auto study = make_study({spec, experiment, results, cache});
      results.studies.push_back({spec.name, spec.type, study->numbers, study});
    }
  }
  std::vector<ReportSection> report(const Experiment& experiment, const ExperimentResults& results,
                                    const std::filesystem::path& folder) const override {
    std::vector<ReportSection> sections;
    for (const StudyOutcome& study : results.studies) {
      for (ReportSection& section : study.study->report(experiment.title, folder)) {
        sections.push_back(std::move(section));
      }
    }
    return sections;
  }

 private:
  static std::logic_error no_jobs() { return std::logic_error("studies have no jobs"); }
};

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

std::optional<double> StudyInput::latency_s(const std::string& label) const {
  for (const ResultRow& row : results.rows) {
    if (row.label == label && row.latency_us) return row.latency_us->p50 * 1e-6;
  }
  return std::nullopt;
}

std::string StudyInput::law() const { return name_of(experiment.sensor.skin->law); }

std::vector<HeadlineSpread> spread_of(std::span<const std::vector<Headline>> of_trainings) {
  std::vector<HeadlineSpread> out;
  for (const Headline& first : of_trainings.front()) {
    HeadlineSpread spread{first.label, first.what, first.decimals, {first.value}};
    for (const std::vector<Headline>& training : of_trainings.subspan(1)) {
      const auto found = std::ranges::find_if(training, [&](const Headline& headline) {
        return headline.label == first.label && headline.what == first.what;
      });
      if (found != training.end()) spread.values.push_back(found->value);
    }
    if (spread.values.size() > 1) out.push_back(std::move(spread));
  }
  // Headlines come set by set; here a solver's numbers stand together.
  const std::vector<HeadlineSpread> by_set = out;
  const auto place = [&](const HeadlineSpread& one) {
    return std::ranges::find(by_set, one.label, &HeadlineSpread::label);
  };
  std::ranges::stable_sort(
      out, [&](const HeadlineSpread& a, const HeadlineSpread& b) { return place(a) < place(b); });
  return out;
}

std::shared_ptr<const Study> make_study(const StudyInput& input) {
  const auto study_of = studies.at(input.spec.type);
  const auto first = std::make_shared<Study>(study_of(input));
  std::vector<std::vector<Headline>> of_trainings = {first->best};
  for (std::size_t training = 1; training < input.trainings(); ++training) {
    StudyInput again = input;
    again.training = training;
    of_trainings.push_back(study_of(again).best);
  }
  if (of_trainings.size() > 1) add_trainings(spread_of(of_trainings), *first);
  return first;
}

std::unique_ptr<Stage> study_stage() { return std::make_unique<StudyStage>(); }

}  // namespace ertbench
