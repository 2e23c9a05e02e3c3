#include "bench/run/results.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/plot/canvas.h"
#include "bench/record/record_file.h"
#include "bench/report/chart.h"
#include "bench/report/differences.h"
#include "bench/report/reconstruction_figure.h"
#include "bench/score/metrics.h"
#include "bench/table/table.h"
#include "bench/training/training_chart.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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
      const auto row = std::ranges::find(results.rows, column.label, &ResultRow::label);
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

/// What `ertbench report` needs beside the rows, with the names of what it cannot make again.
json presentation(const Experiment& experiment, const ExperimentResults& results,
                  const TableText& text, bool trained) {
  json out = *experiment.presentation;
  for (const DatasetSpec& test : experiment.tests) {
    out["test_sets"].push_back(
        {{"name", test.name}, {"description", text.dataset_descriptions.at(test.name)}});
  }
  for (const auto& trials : experiment.rows()) {
    const SolverEntry& entry = trials.front();
    json& solver = out["solvers"].emplace_back(json{{"label", entry.label}});
    if (entry.family != entry.label) solver["family"] = entry.family;
    if (entry.sweep) solver["sweep"] = *entry.sweep;
    if (entry.break_even_reference) solver["break_even_reference"] = true;
  }
  json& absent = out["elsewhere"] = json::array();
  if (!results.frames.empty()) absent.push_back("differences");
  if (!experiment.figure_scenes.empty()) absent.push_back("reconstructions");
  if (trained) absent.push_back("training");
  if (experiment.ladders) absent.push_back("ladders");
  if (experiment.folds) absent.push_back("folds");
  for (const StudyOutcome& study : results.studies) absent.push_back(study.name);
  return out;
}

/// What stands around the tables of a result, but for the builds.
TableText table_text(const Experiment& experiment, const json& summary) {
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

/// A row for programs: calls `add(title, cell)` for each column in turn.
template <typename Add>
void add_cells(const ResultRow& row, const PublishedTable& published, const Add& add) {
  const auto add_ends = [&](const std::string& name, const std::optional<Interval>& ends) {
    add(name + "_low", exact_cell(ends ? std::optional(ends->low) : std::nullopt));
    add(name + "_high", exact_cell(ends ? std::optional(ends->high) : std::nullopt));
  };
  add("dataset", row.dataset);
  add("label", row.label);
  add("type", row.type);
  add("status", row.status);
  add("message", row.message);
  add("frames", std::to_string(row.frames));
  add("undefined_frames", std::to_string(row.undefined_frames));
  add("frames_not_converged", std::to_string(row.frames_not_converged));
  add("suspect_frames", std::to_string(row.suspect_frames));
  for (const Metric metric : kMetrics) {
    const std::string name = name_of(metric);
    const MetricSummary& summary = row.metrics[metric];
    add(name + "_mean", exact_cell(summary.mean));
    add_ends(name, summary.ci95);
    add(name + "_median", exact_cell(summary.median));
    add_ends(name + "_median", summary.median_ci95);
    add(name + "_count", std::to_string(summary.count));
    add(name + "_undefined", std::to_string(summary.undefined));
    add(name + "_seed_deviation",
        exact_cell(row.seeds ? row.seeds->deviation[metric] : std::nullopt));
    if (!entry_of(metric).published) continue;
    const std::optional<double> paper = published_value(published, row, metric);
    add(name + "_paper", exact_cell(paper));
    add(name + "_difference",
        exact_cell(paper && summary.mean ? std::optional(*summary.mean - *paper) : std::nullopt));
  }
  const std::optional<OverLimit>& over = row.over_limit;
  add("relative_error_over_limit", exact_cell(over ? std::optional(over->ratio) : std::nullopt));
  add_ends("relative_error_over_limit", over ? std::optional(over->ci95) : std::nullopt);
  const std::optional<LatencySummary>& latency = row.latency_us;
  add("latency_p50_us", exact_cell(latency ? std::optional(latency->p50) : std::nullopt));
  add("latency_p99_us", exact_cell(latency ? std::optional(latency->p99) : std::nullopt));
  add("latency_max_us", exact_cell(latency ? std::optional(latency->max) : std::nullopt));
  add("contacts_p50_us", exact_cell(latency ? latency->contacts_p50 : std::nullopt));
  add("contacts_p99_us", exact_cell(latency ? latency->contacts_p99 : std::nullopt));
  add("latency_pipe_us", exact_cell(latency ? latency->pipe : std::nullopt));
  add("frames_per_s", exact_cell(row.frames_per_s));
  add("throughput_batch", row.throughput_batch > 0 ? std::to_string(row.throughput_batch) : "");
  add("fit_s", exact_cell(row.fit_s));
  add("peak_rss_mb", exact_cell(row.peak_rss_mb));
  add("seeds", row.seeds ? joined(row.seeds->values, " ") : "");
  add("sweep", row.sweep.text());
  add("parameters", row.parameters.text());
}

}  // namespace

std::size_t write_rows(const Experiment& experiment, const std::vector<ResultRow>& rows,
                       const TableText& text, BesideRows beside, json summary,
                       const fs::path& folder) {
  summary["rows"] = json::array();
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

std::size_t write_results(const Experiment& experiment, const Cache& cache,
                          const ExperimentResults& results,
                          const std::vector<ReportSection>& sections, const fs::path& folder) {
  json summary = {{"schema", 1},
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
    const fs::path file = cache.dataset(test);
    if (!fs::exists(file)) continue;
    const MissedPromise missed = missed_promise(test, DatasetFile(file));
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
  summary["presentation"] = presentation(experiment, results, text, !training_curves.empty());
  for (const StudyOutcome& study : results.studies) {
    summary["studies"][study.name] = *study.summary;
    summary["studies"][study.name]["type"] = study.type;
  }
  return write_rows(experiment, results.rows, text, {training_curves, sections, undrawn}, summary,
                    folder);
}

TableSection result_data(std::span<const ResultRow> rows, const PublishedTable& published) {
  TableSection section;
  add_cells(ResultRow(), published,
            [&](const std::string& title, const Cell&) { section.columns.emplace_back(title); });
  for (const ResultRow& row : rows) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    add_cells(row, published, [&](const std::string&, Cell cell) { cells.push_back(cell); });
  }
  return section;
}

}  // namespace ertbench
