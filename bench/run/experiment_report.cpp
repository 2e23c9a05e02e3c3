#include <nlohmann/json.hpp>

#include "bench/report/chart.h"
#include "bench/run/results.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::string range_text(const std::pair<double, double>& interval) {
  const std::string low = number_text(interval.first);
  return interval.first == interval.second ? low : low + " to " + number_text(interval.second);
}

std::string added_noise_text(const Noise& noise) {
  return number_text(*noise.snr_db) + " dB SNR (" + name_of(noise.basis) + " basis)";
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

ReportSection results_section(TableSection table) {
  ReportSection section{
      .title = "Results: " + table.caption, .text = table.text, .notes = table.notes};
  table.caption = "Test set " + table.caption;
  section.tables = {std::move(table)};
  return section;
}

/// Charts without a section of their own share one.
std::vector<ReportSection> chart_sections(const Experiment& experiment,
                                          const std::vector<ResultRow>& rows,
                                          const std::filesystem::path& folder) {
  ReportSection shared{.title = "Charts"};
  std::vector<ReportSection> sections;
  for (const auto& chart : experiment.charts) {
    const ReportFigure figure{chart->name(), folder / (chart->name() + ".svg"), chart->caption()};
    if (chart->section().empty()) {
      shared.figures.push_back(figure);
      continue;
    }
    Table table = chart->table(rows);
    sections.push_back({.title = chart->section(),
                        .text = std::move(table.text),
                        .figures = {figure},
                        .tables = std::move(table.sections)});
  }
  if (!shared.figures.empty()) sections.insert(sections.begin(), shared);
  return sections;
}

std::string value_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_object()) return json_text(value);
  std::string out;
  for (const auto& [key, part] : value.items()) {
    out += (out.empty() ? "" : ", ") + key + " " + value_text(part);
  }
  return out;
}

/// "1, 2, 3" of each label that was trained more than once.
std::string training_seeds(const std::vector<ResultRow>& rows, const std::string& dataset) {
  std::string out;
  for (const ResultRow& row : rows) {
    if (!row.seeds || row.dataset != dataset) continue;
    out += (out.empty() ? "" : "; ") + row.label + ": " + joined(row.seeds->values);
  }
  return out;
}

/// JSON with a line for each setting of each dataset.
std::string recipes_text(const json& datasets) {
  std::string out;
  for (const auto& [name, recipe] : datasets.items()) {
    out += (out.empty() ? "{\n" : ",\n") + json_text(name) + ": {";
    const char* separator = "\n  ";
    for (const auto& [key, value] : recipe.items()) {
      out += separator + json_text(key) + ": " + json_text(value);
      separator = ",\n  ";
    }
    out += "\n}";
  }
  return out + "\n}";
}

std::vector<ReportSection> provenance_sections(const Experiment& experiment,
                                               const std::vector<ResultRow>& rows,
                                               const json& provenance) {
  TableSection table;
  table.caption = "What the numbers were made with";
  table.columns = {{"what", Align::left}, {"value", Align::left}};
  for (const auto& [key, value] : provenance.items()) {
    if (key == "datasets") continue;
    table.rows.push_back({key == "seeds" ? "seeds of datasets" : key, value_text(value)});
    const std::string trained = training_seeds(rows, experiment.tests.front().name);
    if (key == "seeds" && !trained.empty()) table.rows.push_back({"seeds of training", trained});
  }
  return {{.title = "Provenance", .tables = {table}},
          {.title = "Recipes of the datasets",
           .code = recipes_text(provenance.at("datasets")),
           .collapsed = true}};
}

}  // namespace

std::string description(const DatasetSpec& spec) {
  if (spec.measured()) return measured_description(spec);
  std::string text = std::to_string(spec.count) + " scenes, ";
  if (const auto* d = std::get_if<SceneDistribution>(&spec.scenes)) {
    const std::string shapes =
        joined(d->shapes, ", ", [](DrawnShape shape) { return name_of(shape); });
    text += range_text(d->contacts) + " contact(s) each (" + shapes + "), radius " +
            range_text(d->radius) + " (sheet " + spec.sensor.sheet->extent() + "), conductivity " +
            range_text(d->conductivity_ratio) + " of the background, placed " +
            (d->inside ? "inside the sheet" : "with their centres inside the sheet");
  } else {
    text += "listed in the experiment";
  }
  if (const auto* grid = std::get_if<GridSheet>(&spec.model)) {
    text += "; voltages from a " + std::to_string(grid->side) + " x " + std::to_string(grid->side) +
            " grid" + (grid->side == spec.sensor.image_grid ? ", that of the images" : "") + "; ";
  } else {
    text += "; voltages of the continuous sheet to " +
            number_text(std::get<ContinuousSheet>(spec.model).model_error) + " of the noise; ";
  }
  if (spec.noise.snr_db) {
    text += added_noise_text(spec.noise);
  } else {
    text += "no noise";
  }
  if (spec.faults.any()) text += "; faults " + json_text(to_json(spec.faults));
  return text + "; seed " + std::to_string(spec.seed);
}

Report report_of(const Experiment& experiment, const std::vector<ResultRow>& rows,
                 const TableText& text, const std::vector<ReportFigure>& training_curves,
                 const std::vector<ReportSection>& ladders, const json& provenance,
                 const std::filesystem::path& folder) {
  Report report;
  report.title = experiment.title;
  if (experiment.question != experiment.title) report.question = experiment.question;
  const auto append = [&](const std::vector<ReportSection>& sections) {
    report.sections.insert(report.sections.end(), sections.begin(), sections.end());
  };
  const Table results = result_table(rows, text);
  for (const TableSection& table : results.sections) append({results_section(table)});
  append({{.title = "How to read the tables",
           .text = "Beside this page: the same tables as table.md, table.csv (all digits) and "
                   "table.tex; summary.json with the parameters in use and the medians; a record "
                   "of every frame.",
           .notes = results.legend}});
  append(ladders);
  append(chart_sections(experiment, rows, folder));
  if (!experiment.figure_scenes.empty()) {
    append({{.title = "Reconstructions",
             .figures = {{"True images and reconstructions", folder / "reconstructions.svg",
                          "scenes of the test set " + experiment.tests.front().name +
                              ", below each image its relative error of δσ"}}}});
  }
  if (!training_curves.empty()) {
    append({{.title = "Training curves",
             .text = "All values of each epoch are in training/, a CSV file for each training run.",
             .figures = training_curves,
             .collapsed = true}});
  }
  append(provenance_sections(experiment, rows, provenance));
  append({{.title = "To make it again", .code = text.command}});
  return report;
}

}  // namespace ertbench
