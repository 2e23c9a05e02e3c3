#include "bench/studies/consistency.h"

#include <nlohmann/json.hpp>

#include "bench/report/report.h"
#include "bench/studies/consistency_figure.h"
#include "bench/studies/study_text.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

ConsistentSet consistent_set(const StudyInput& input, const std::string& name, double outlier_mm) {
  ConsistentSet set;
  set.name = name;
  set.empty = input.spec.roles.at("empty");
  std::vector<MeasuredPath> paths;
  for (const std::string& label : input.labels()) {
    ConsistencyOfSolver& solver = set.solvers.emplace_back();
    solver.label = label;
    solver.latency = input.latency(label);
    const auto* moving = input.readings(label, name);
    if (!moving || !input.readings(label, set.empty)) {
      solver.failure = input.failure(label);
      continue;
    }
    solver.path = path_of(*moving);
    paths.push_back(solver.path);
  }
  const MeasuredPath middle = middle_path(paths);
  for (ConsistencyOfSolver& solver : set.solvers) {
    if (!solver.failure.empty()) continue;
    solver.scores =
        consistency_scores({*input.readings(solver.label, name),
                            *input.readings(solver.label, set.empty), middle, outlier_mm},
                           name + solver.label);
  }
  return set;
}

/// The estimates with the names that summary.json and the data have for them.
std::vector<std::pair<const char*, std::optional<Estimate>>> estimates_of(
    const ConsistencyScores& scores) {
  return {{"radius_mm", scores.radius_mm},
          {"radius_spread", scores.radius_spread},
          {"amplitude_spread", scores.amplitude_spread},
          {"peak_spread", scores.peak_spread},
          {"step_mm", scores.step_mm},
          {"jerk_mm", scores.jerk_mm},
          {"more_contacts", scores.more_contacts},
          {"explained", scores.explained},
          {"apart_mm", scores.apart_mm}};
}

std::string share_of(std::size_t part, std::size_t whole) {
  return std::to_string(part) + " of " + std::to_string(whole);
}

TableSection table_of(const ConsistentSet& set) {
  TableSection table;
  table.caption = set.name + ": one thing moves; empty frames: " + set.empty;
  table.columns = {{"solver", Align::left},
                   {"frames with a contact"},
                   {"radius, mm"},
                   {"spread of the radius"},
                   {"of the image's sum"},
                   {"of its peak"},
                   {"jerk, mm", Align::right, 1},
                   {"outliers", Align::right, 1},
                   {"more contacts", Align::right, 1},
                   {"explained", Align::right, 1},
                   {"from the middle, mm", Align::right, 1},
                   {"false contacts", Align::right, 1},
                   {"p50, µs", Align::right, 1}};
  for (const ConsistencyOfSolver& solver : set.solvers) {
    std::vector<Cell> row = {solver.label};
    if (!solver.failure.empty()) {
      row.emplace_back(solver.failure);
      row.resize(table.columns.size());
      table.rows.push_back(std::move(row));
      continue;
    }
    const ConsistencyScores& scores = solver.scores;
    row.emplace_back(share_of(scores.seen, scores.frames));
    row.push_back(estimate_cell(scores.radius_mm, 1));
    row.push_back(estimate_cell(scores.radius_spread, 3));
    row.push_back(estimate_cell(scores.amplitude_spread, 3));
    row.push_back(estimate_cell(scores.peak_spread, 3));
    row.push_back(estimate_cell(scores.jerk_mm, 2));
    row.emplace_back(std::to_string(scores.outliers));
    row.push_back(estimate_cell(scores.more_contacts, 2));
    row.push_back(estimate_cell(scores.explained, 3));
    row.push_back(estimate_cell(scores.apart_mm, 1));
    row.emplace_back(share_of(scores.false_contacts, scores.empty_frames));
    row.push_back(
        number_cell(solver.latency ? std::optional(solver.latency->p50_s * 1e6) : std::nullopt, 1));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TableSection data_of(const std::vector<ConsistentSet>& sets) {
  TableSection data;
  data.columns = {{"set", Align::left}, {"solver", Align::left}, {"frames"}, {"seen"}};
  for (const auto& [name, value] : estimates_of({})) {
    for (const Column& column : exact_columns(name)) data.columns.push_back(column);
  }
  data.columns.insert(data.columns.end(), {{"outliers"}, {"empty_frames"}, {"false_contacts"}});
  for (const ConsistentSet& set : sets) {
    for (const ConsistencyOfSolver& solver : set.solvers) {
      if (!solver.failure.empty()) continue;
      const ConsistencyScores& scores = solver.scores;
      std::vector<Cell> row = {set.name, solver.label, std::to_string(scores.frames),
                               std::to_string(scores.seen)};
      for (const auto& [name, value] : estimates_of(scores)) {
        for (const Cell& cell : exact_cells(value)) row.push_back(cell);
      }
      row.emplace_back(std::to_string(scores.outliers));
      row.emplace_back(std::to_string(scores.empty_frames));
      row.emplace_back(std::to_string(scores.false_contacts));
      data.rows.push_back(std::move(row));
    }
  }
  return data;
}

}  // namespace

Consistency::Consistency(const StudyInput& input)
    : name_(input.spec.name),
      sensor_(input.experiment.sensor),
      outlier_mm_(input.spec.number("outlier") * 2 * sensor_.sheet->radius() *
                  sensor_.sheet->unit_mm()) {
  for (const std::string& set : input.spec.sets) {
    sets_.push_back(consistent_set(input, set, outlier_mm_));
  }
}

json Consistency::summary() const {
  json out = {{"outlier_mm", outlier_mm_}};
  for (const ConsistentSet& set : sets_) {
    json& one = out["sets"][set.name];
    one = {{"empty", set.empty}};
    for (const ConsistencyOfSolver& solver : set.solvers) {
      json& row = one["solvers"][solver.label];
      if (!solver.failure.empty()) {
        row = {{"failure", solver.failure}};
        continue;
      }
      const ConsistencyScores& scores = solver.scores;
      row = {{"frames", scores.frames},
             {"seen", scores.seen},
             {"outliers", scores.outliers},
             {"empty_frames", scores.empty_frames},
             {"false_contacts", scores.false_contacts}};
      for (const auto& [name, value] : estimates_of(scores)) row[name] = to_json(value);
    }
  }
  return out;
}

std::vector<Headline> Consistency::headlines() const {
  std::vector<Headline> out;
  for (const ConsistentSet& set : sets_) {
    for (const ConsistencyOfSolver& solver : set.solvers) {
      if (!solver.failure.empty()) continue;
      out.push_back({solver.label, set.name + ": spread of the radius (of its median)", 3,
                     value_of(solver.scores.radius_spread)});
      out.push_back({solver.label, set.name + ": share of the change explained", 3,
                     value_of(solver.scores.explained)});
    }
  }
  return out;
}

std::vector<ReportSection> Consistency::report(const std::string& title,
                                               const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Consistency: measured frames without a truth";
  section.text =
      "One thing of constant size moves over the sheet, and nobody knows where it is. So what "
      "should be constant is held against itself. Radius: of the disc of the strongest contact's "
      "area. Spread: the range of the middle half of the frames, in normal deviations, over the "
      "median. Jerk: the median third difference of the path. Outliers: places farther than " +
      fixed(outlier_mm_, 1) +
      " mm from the median of the four frames around them. Explained: the share of the voltages' "
      "change that the image's linear response explains, at the best amplitude and with the "
      "sheet's level free. From the middle: the median distance to the median place of all "
      "methods. False contacts: of the frames with nothing on the sheet. Intervals: 95 %, by the "
      "bootstrap over blocks of ten frames.";
  for (const ConsistentSet& set : sets_) {
    section.tables.push_back(table_of(set));
    section.figures.push_back(
        path_figure(set, sensor_, title, folder / (name_ + "_paths_" + set.name)));
  }
  write_study_tables({title, section.text, section.tables, {}, {}}, data_of(sets_), folder, name_);
  return {section};
}

}  // namespace ertbench
