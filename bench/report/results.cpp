#include "bench/report/results.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/analysis/differences.h"
#include "bench/charts/chart.h"
#include "bench/charts/reconstruction_figure.h"
#include "bench/plot/drawing.h"
#include "bench/record/provenance.h"
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

std::string interval_text(const std::pair<double, double>& interval) {
  char text[64];
  if (interval.first == interval.second) {
    std::snprintf(text, sizeof text, "%g", interval.first);
  } else {
    std::snprintf(text, sizeof text, "%g to %g", interval.first, interval.second);
  }
  return text;
}

std::string added_noise_text(const Noise& noise) {
  char snr[64];
  std::snprintf(snr, sizeof snr, "%g dB SNR (%s basis)", *noise.snr_db, name_of(noise.basis));
  return snr;
}

std::string measured_description(const DatasetSpec& spec) {
  const MeasuredFrames& frames = *spec.measured();
  std::string text = std::to_string(spec.count) + " frames of " + frames.name + " (checksum " +
                     frames.checksum + "), rows " + std::to_string(frames.first) + " to " +
                     std::to_string(frames.last - 1);
  if (const auto& fold = frames.fold) {
    text += ", of fold " + std::to_string(fold->number + 1) + " of " + std::to_string(fold->count) +
            (fold->held_out ? " the part held out" : " the rest");
  }
  if (!frames.truth.places) text += "; where contacts are is not known";
  if (!frames.truth.images) text += "; true images are not known";
  if (spec.noise.snr_db) text += "; noise that trainings add, " + added_noise_text(spec.noise);
  return text;
}

/// A dataset in a sentence, for the tables' legends.
std::string description(const DatasetSpec& spec) {
  if (spec.measured()) return measured_description(spec);
  std::string text = std::to_string(spec.count) + " scenes, ";
  if (const auto* d = std::get_if<SceneDistribution>(&spec.scenes)) {
    std::string shapes;
    for (const DrawnShape shape : d->shapes) {
      shapes += (shapes.empty() ? "" : ", ") + std::string(name_of(shape));
    }
    text += interval_text(d->contacts) + " contact(s) each (" + shapes + "), radius " +
            interval_text(d->radius) + " (sheet " + spec.sensor.sheet->extent() +
            "), conductivity " + interval_text(d->conductivity_ratio) +
            " of the background, placed " +
            (d->inside ? "inside the sheet" : "with their centres inside the sheet");
  } else {
    text += "listed in the experiment";
  }
  if (const auto* grid = std::get_if<GridSheet>(&spec.model)) {
    text += "; voltages from a " + std::to_string(grid->side) + " x " + std::to_string(grid->side) +
            " grid" + (grid->side == spec.sensor.image_grid ? ", that of the images" : "") + "; ";
  } else {
    char fraction[64];
    std::snprintf(fraction, sizeof fraction, "%g",
                  std::get<ContinuousSheet>(spec.model).model_error);
    text += std::string("; voltages of the continuous sheet to ") + fraction + " of the noise; ";
  }
  if (spec.noise.snr_db) {
    text += added_noise_text(spec.noise);
  } else {
    text += "no noise";
  }
  if (spec.faults.any()) text += "; faults " + json_text(to_json(spec.faults));
  return text + "; seed " + std::to_string(spec.seed);
}

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

}  // namespace

std::size_t write_results(const Experiment& experiment, const Cache& cache,
                          const ExperimentResults& results,
                          const std::vector<ReportSection>& sections, const fs::path& folder) {
  TableText text;
  text.title = experiment.title;
  text.published = experiment.published;
  text.builds = results.builds;
  text.command = results.command.empty()
                     ? "./ertbench run " + printable_path(experiment.file.string())
                     : results.command;
  nlohmann::json missed_promises = nlohmann::json::object();
  for (const DatasetSpec& test : experiment.tests) {
    text.dataset_descriptions[test.name] = description(test);
    const MissedPromise missed = missed_promise_in(cache.dataset(test), test);
    if (missed.scenes == 0) continue;
    text.dataset_descriptions[test.name] += "; " + missed.sentence();
    missed_promises[test.name] = {{"scenes", missed.scenes},
                                  {"of", missed.of},
                                  {"model_error", missed.model_error},
                                  {"largest_error", missed.largest_error},
                                  {"sentence", missed.sentence()}};
  }
  nlohmann::json summary = {{"schema", 1},
                            {"experiment", experiment.name},
                            {"title", experiment.title},
                            {"question", experiment.question},
                            {"command", text.command},
                            {"provenance", provenance(experiment, results.jobs, results.measured)},
                            {"builds", to_json(results.builds)},
                            {"rows", nlohmann::json::array()}};
  if (!experiment.overrides.empty()) summary["set"] = experiment.overrides;
  if (!missed_promises.empty()) summary["missed_promises"] = missed_promises;
  for (const ResultRow& row : results.rows) summary["rows"].push_back(to_json(row));
  const Table table = result_table(results.rows, text);
  write_file_atomically(folder / "table.md", markdown_of(table));
  write_file_atomically(folder / "table.csv",
                        csv_of(result_data(results.rows, experiment.published)));
  write_file_atomically(folder / "table.tex", latex_of(table));
  std::vector<std::string> undrawn = undrawn_of(sections);
  if (!draw_figure(experiment, cache, results, folder)) undrawn.emplace_back("reconstructions");
  write_differences(results, folder);
  for (const auto& chart : experiment.charts) {
    const bool drawn = draw_or_say(folder / chart->name(),
                                   [&] { chart->draw(results.rows, experiment.title, folder); });
    if (!drawn) undrawn.push_back(chart->name());
    chart->summarise(results.rows, summary);
  }
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
  if (!undrawn.empty()) summary["undrawn"] = undrawn;
  const Report report = report_of(experiment, results.rows, text, training_curves, sections,
                                  summary.at("provenance"), folder);
  write_file_atomically(folder / "report.html", report_html(report));
  write_file_atomically(folder / "summary.json", json_text(summary, 2) + "\n");
  return undrawn.size();
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
