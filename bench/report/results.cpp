#include "bench/report/results.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/analysis/differences.h"
#include "bench/charts/chart.h"
#include "bench/charts/reconstruction_figure.h"
#include "bench/plot/drawing.h"
#include "bench/record/provenance.h"
#include "bench/report/dataset_description.h"
#include "bench/report/experiment_report.h"
#include "bench/report/result_table.h"
#include "bench/report/training_results.h"
#include "bench/score/metric_summary.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/json_text.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/missed_promise.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// Nothing where the file is no longer there.
MissedPromise missed_promise_in(const fs::path& file, const DatasetSpec& spec) {
  if (!fs::exists(file)) return {};
  return missed_promise(spec, DatasetFile(file));
}

/// Truth of the figure's scenes and the column of every solver.
bool draw_figure(const Experiment& experiment, const Cache& cache, const ExperimentResults& results,
                 const fs::path& folder) {
  if (experiment.figure_scenes.empty()) return true;
  const DatasetSpec& test = experiment.tests.front();
  const DatasetFile set = cache.open_dataset(test);
  const auto count = static_cast<Eigen::Index>(experiment.figure_scenes.size());
  ReconstructionFigure figure;
  figure.sensor = experiment.sensor;
  figure.truth_is_known = set.truth().images || set.truth().places;
  figure.conductivity.resize(count, experiment.sensor.pixels());
  std::vector<Scene> scenes;
  for (Eigen::Index i = 0; i < count; ++i) {
    const int scene = experiment.figure_scenes[static_cast<std::size_t>(i)];
    const auto index = static_cast<std::uint64_t>(scene);
    figure.conductivity.row(i) = set.conductivity(index, 1);
    scenes.push_back(set.scenes(index, 1).front());
    figure.row_labels.push_back("scene " + std::to_string(scene));
  }
  for (const auto& trials : experiment.rows()) {
    FigureColumn column;
    column.label = trials.front().label;
    const auto images = results.images.find(column.label);
    if (images != results.images.end()) {
      column.changes = images->second;
      for (Eigen::Index i = 0; set.truth().images && i < count; ++i) {
        column.errors.push_back(frame_metric(Metric::relative_error, experiment.sensor,
                                             figure.conductivity.row(i), column.changes.row(i),
                                             scenes[static_cast<std::size_t>(i)]));
      }
    } else {
      const auto row = std::find_if(results.rows.begin(), results.rows.end(),
                                    [&](const ResultRow& r) { return r.label == column.label; });
      column.failure = row == results.rows.end() ? "not run" : row->status;
    }
    figure.columns.push_back(std::move(column));
  }
  const fs::path stem = folder / "reconstructions";
  return draw_or_say(stem, [&] { draw_reconstruction_figure(figure, stem); });
}

/// The figures of the stages that could not be drawn, by their files' names.
std::vector<std::string> undrawn_of(const std::vector<ReportSection>& sections) {
  std::vector<std::string> names;
  for (const ReportSection& section : sections) {
    for (const ReportFigure& figure : section.figures) {
      if (!figure.drawn) names.push_back(figure.svg.stem().string());
    }
  }
  return names;
}

/// differences.csv and differences.md, where there are two rows to compare.
void write_differences(const ExperimentResults& results, const fs::path& folder) {
  std::vector<MeanDifference> differences;
  for (const ScoredLabels& scored : results.frames) {
    const std::vector<MeanDifference> of_set = mean_differences(scored);
    differences.insert(differences.end(), of_set.begin(), of_set.end());
  }
  if (differences.empty()) return;
  write_file_atomically(folder / "differences.csv", csv_of(difference_data(differences)));
  write_file_atomically(folder / "differences.md", markdown_of(difference_table(differences)));
}

/// What stands around the tables of a result, but for the builds.
TableText table_text(const Experiment& experiment, const nlohmann::json& summary) {
  TableText text;
  text.title = experiment.title;
  text.published = experiment.published;
  text.command = summary.at("command");
  const auto missed = summary.find("missed_promises");
  for (const DatasetSpec& test : experiment.tests) {
    std::string& sentence = text.dataset_descriptions[test.name] = description(test);
    if (missed != summary.end() && missed->contains(test.name)) {
      sentence += "; " + missed->at(test.name).at("sentence").get<std::string>();
    }
  }
  return text;
}

/// What the page has beside the rows, their tables and charts.
struct BesideRows {
  std::vector<ReportFigure> training_curves;
  std::vector<ReportSection> sections;
  std::vector<std::string> undrawn;  ///< figures that could not be drawn
};

/// The tables, the charts, the page and summary.json. Returns how many figures could not be drawn.
std::size_t write_rows(const Experiment& experiment, const std::vector<ResultRow>& rows,
                       const TableText& text, BesideRows beside, nlohmann::json summary,
                       const fs::path& folder) {
  summary["rows"] = nlohmann::json::array();
  for (const ResultRow& row : rows) summary["rows"].push_back(to_json(row));
  const Table table = result_table(rows, text);
  write_file_atomically(folder / "table.md", markdown_of(table));
  write_file_atomically(folder / "table.csv", csv_of(result_data(rows, experiment.published)));
  write_file_atomically(folder / "table.tex", latex_of(table));
  for (const auto& chart : experiment.charts) {
    const bool drawn =
        draw_or_say(folder / chart->name(), [&] { chart->draw(rows, experiment.title, folder); });
    if (!drawn) beside.undrawn.push_back(chart->name());
    chart->summarise(rows, summary);
  }
  summary.erase("undrawn");
  if (!beside.undrawn.empty()) summary["undrawn"] = beside.undrawn;
  const Report report = report_of(experiment, rows, text, beside.training_curves, beside.sections,
                                  summary.at("provenance"), folder);
  write_file_atomically(folder / "report.html", report_html(report));
  write_file_atomically(folder / "summary.json", json_text(summary, 2) + "\n");
  return beside.undrawn.size();
}

/// Each once, in the order of the alphabet, as ExperimentResults::training has them.
std::set<std::string> labels_of(const std::vector<ResultRow>& rows) {
  std::set<std::string> labels;
  for (const ResultRow& row : rows) labels.insert(row.label);
  return labels;
}

Builds builds_from_json(const nlohmann::json& json) {
  Builds builds;
  for (const auto& [what, stamps] : json.items()) {
    for (const nlohmann::json& stamp : stamps) {
      if (const auto build = build_stamp_from_json(stamp)) builds[what].push_back(*build);
    }
  }
  return builds;
}

}  // namespace

std::size_t write_results(const Experiment& experiment, const Cache& cache,
                          const ExperimentResults& results,
                          const std::vector<ReportSection>& sections, const fs::path& folder) {
  nlohmann::json summary = {
      {"schema", 1},
      {"experiment", experiment.name},
      {"title", experiment.title},
      {"question", experiment.question},
      {"command", results.command.empty()
                      ? "./ertbench run " + printable_path(experiment.file.string())
                      : results.command},
      {"provenance", provenance(experiment, results.jobs, results.measured)},
      {"builds", to_json(results.builds)}};
  if (!experiment.overrides.empty()) summary["set"] = experiment.overrides;
  for (const DatasetSpec& test : experiment.tests) {
    const MissedPromise missed = missed_promise_in(cache.dataset(test), test);
    if (missed.scenes == 0) continue;
    summary["missed_promises"][test.name] = {{"scenes", missed.scenes},
                                             {"of", missed.of},
                                             {"model_error", missed.model_error},
                                             {"largest_error", missed.largest_error},
                                             {"sentence", missed.sentence()}};
  }
  TableText text = table_text(experiment, summary);
  text.builds = results.builds;
  std::vector<std::string> undrawn = undrawn_of(sections);
  if (!draw_figure(experiment, cache, results, folder)) undrawn.emplace_back("reconstructions");
  write_differences(results, folder);
  std::vector<ReportFigure> training_curves;
  for (const auto& [label, sources] : results.training) {
    const auto figure = write_training_results(label, sources, folder / "training");
    if (!figure) continue;
    if (!figure->drawn) undrawn.push_back("training/" + label);
    training_curves.push_back(*figure);
  }
  for (const StudyOutcome& study : results.studies) {
    summary["studies"][study.name] = study.result->summary();
    summary["studies"][study.name]["type"] = study.type;
  }
  return write_rows(experiment, results.rows, text, {training_curves, sections, undrawn}, summary,
                    folder);
}

std::size_t rewrite_results(const Experiment& experiment, const std::vector<ResultRow>& rows,
                            const std::string& clocks, nlohmann::json summary,
                            const fs::path& folder) {
  TableText text = table_text(experiment, summary);
  text.builds = builds_from_json(summary.at("builds"));
  if (!clocks.empty()) text.builds.erase("timing");  // it says it
  text.clocks = clocks;
  std::vector<ReportFigure> training_curves;
  for (const std::string& label : labels_of(rows)) {
    if (const auto figure = training_figure(label, folder / "training")) {
      training_curves.push_back(*figure);
    }
  }
  return write_rows(experiment, rows, text, {training_curves, {}, {}}, std::move(summary), folder);
}

std::size_t report_results(const Experiment& experiment, const Cache& cache,
                           const ExperimentResults& results,
                           const std::vector<ReportSection>& sections, const fs::path& folder) {
  const std::size_t undrawn = write_results(experiment, cache, results, sections, folder);
  std::printf("%s\nResults in %s\n", terminal_of(result_summary(results.rows)).c_str(),
              printable_path(folder.string()).c_str());
  return undrawn;
}

}  // namespace ertbench
