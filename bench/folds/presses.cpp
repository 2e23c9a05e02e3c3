#include "bench/folds/presses.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/folds/presses_figure.h"
#include "bench/report/report.h"
#include "bench/studies/study.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

constexpr std::size_t most_strengths = 6;  ///< that are told apart
constexpr int rings = 4;
constexpr int border_points = 180;

using Held = std::vector<const HeldOutPress*>;

double error_of(const HeldOutPress& press, const Vector2d& middle) {
  return (press.found_mm.value_or(middle) - press.place_mm).norm();
}

PressErrors errors_of(const Held& presses, const Vector2d& middle, const std::string& title,
                      const std::string& key) {
  PressErrors out;
  out.title = title;
  out.presses = presses.size();
  GroupedErrors errors(presses.size());
  for (std::size_t i = 0; i < presses.size(); ++i) {
    errors.add(i, error_of(*presses[i], middle));
    out.missed += !presses[i]->found_mm.has_value();
  }
  out.mean = errors.mean(key + "mean");
  out.median = errors.quantile(0.5, key + "median");
  out.p95 = errors.quantile(0.95, key + "p95");
  out.worst = errors.worst();
  return out;
}

Held select(const Held& presses, const std::function<bool(const HeldOutPress&)>& wanted) {
  Held out;
  std::copy_if(presses.begin(), presses.end(), std::back_inserter(out),
               [&](const HeldOutPress* press) { return wanted(*press); });
  return out;
}

/// What the parts of a level have in common.
struct Division {
  Vector2d middle;
  double radius_mm;
  std::string strength_name;  ///< empty: not told apart
  double unit_strength;
};

std::vector<PressErrors> by_strength(const Held& presses, const Division& division,
                                     const std::string& key) {
  std::vector<PressErrors> out;
  if (division.strength_name.empty()) return out;
  std::set<double> strengths;
  for (const HeldOutPress* press : presses) {
    strengths.insert(std::round(1e6 * press->strength * division.unit_strength) / 1e6);
  }
  if (strengths.size() > most_strengths) return out;
  for (const double strength : strengths) {
    const Held part = select(presses, [&](const HeldOutPress& press) {
      return std::abs(press.strength * division.unit_strength - strength) < 1e-5 * strength;
    });
    const std::string title = division.strength_name + " " + number_text(strength);
    out.push_back(errors_of(part, division.middle, title, key + title));
  }
  return out;
}

std::vector<PressErrors> by_place(const Held& presses, const Division& division,
                                  const std::string& key) {
  std::vector<PressErrors> out;
  for (int ring = 0; ring < rings; ++ring) {
    const double low = division.radius_mm * ring / rings;
    const double high = division.radius_mm * (ring + 1) / rings;
    const Held part = select(presses, [&](const HeldOutPress& press) {
      const double from = (press.place_mm - division.middle).norm();
      return from >= low && (from < high || ring == rings - 1);
    });
    if (part.empty()) continue;
    const std::string title = fixed(low, 0) + " to " + fixed(high, 0) + " mm";
    out.push_back(errors_of(part, division.middle, title, key + title));
  }
  return out;
}

/// |error| of the strength in the file's units; a press that was not found counts as strength 0.
std::optional<Estimate> strength_error(const Held& presses, const Division& division,
                                       const std::string& key) {
  if (division.strength_name.empty()) return std::nullopt;
  GroupedErrors errors(presses.size());
  for (std::size_t i = 0; i < presses.size(); ++i) {
    errors.add(
        i, std::abs(presses[i]->found_strength - presses[i]->strength) * division.unit_strength);
  }
  return errors.mean(key + "strength");
}

PressSolver solver_of(const FoldsOutcome& outcome, const std::vector<std::uint64_t>& numbers,
                      const Division& division) {
  PressSolver solver{outcome.label, outcome.failure, {}, {}};
  for (std::size_t level = 0; level < numbers.size(); ++level) {
    PressLevel& one = solver.levels.emplace_back();
    one.presses = numbers[level];
    one.failure = outcome.failure;
    Held held;
    for (const FoldRecord& fold : outcome.folds) {
      const FoldRun& run = fold.at(level);
      if (!run.message.empty() && one.failure.empty()) one.failure = run.message;
      Held own;
      for (const HeldOutPress& press : run.held_out) own.push_back(&press);
      if (own.empty()) continue;
      one.fold_means.push_back(errors_of(own, division.middle, "", "").mean->value);
      one.fit_s += run.fit_s / static_cast<double>(outcome.folds.size());
      held.insert(held.end(), own.begin(), own.end());
    }
    if (held.empty()) continue;
    const std::string key = outcome.label + std::to_string(one.presses);
    one.all = errors_of(held, division.middle, "", key);
    one.by_strength = by_strength(held, division, key);
    one.by_place = by_place(held, division, key);
    one.strength = strength_error(held, division, key);
    if (level + 1 < numbers.size()) continue;
    for (const HeldOutPress* press : held) solver.held_out.push_back(*press);
  }
  return solver;
}

json json_of(const PressErrors& errors) {
  json out = {
      {"presses", errors.presses},       {"missed", errors.missed},
      {"mean_mm", to_json(errors.mean)}, {"median_mm", to_json(errors.median)},
      {"p95_mm", to_json(errors.p95)},   {"worst_mm", errors.worst ? json(*errors.worst) : json()}};
  if (!errors.title.empty()) out["part"] = errors.title;
  return out;
}

json json_of(const PressLevel& level) {
  json out = json_of(level.all);
  out["fold_means_mm"] = level.fold_means;
  out["fit_s"] = level.fit_s;
  if (!level.failure.empty()) out["failure"] = level.failure;
  if (level.strength) out["strength_error"] = to_json(level.strength);
  for (const PressErrors& part : level.by_strength) out["by_strength"].push_back(json_of(part));
  for (const PressErrors& part : level.by_place) out["by_place"].push_back(json_of(part));
  return out;
}

std::vector<Cell> error_cells(const PressErrors& errors) {
  return {estimate_cell(errors.mean, 2), estimate_cell(errors.median, 2),
          estimate_cell(errors.p95, 2), number_cell(errors.worst, 1),
          std::to_string(errors.missed)};
}

}  // namespace

Presses::Presses(const Folds& folds, const std::vector<FoldsOutcome>& outcomes)
    : folds_(folds.count), presses_(folds.presses) {
  const MeasuredFrames& frames = *folds.base.measured();
  const Sensor& sensor = folds.base.sensor;
  const double mm = sensor.sheet->unit_mm();
  file_ = frames.name;
  if (!frames.strength_of.empty()) {
    strength_name_ = frames.strength_of.substr(frames.strength_of.find_last_of('/') + 1);
    unit_strength_ = frames.full_strength / (1 - frames.conductivity_ratio);
  }
  const Vector2d middle = sensor.sheet->bounds().center() * mm;
  radius_mm_ = sensor.sheet->radius() * mm;
  for (int i = 0; i <= border_points; ++i) {
    border_mm_.emplace_back(
        sensor.sheet->border_point(sensor.sheet->border_length() * i / border_points) * mm);
  }
  const Eigen::Matrix2Xd electrodes = electrode_positions(sensor) * mm;
  for (const auto& electrode : electrodes.colwise()) electrodes_mm_.emplace_back(electrode);
  const Division division{middle, radius_mm_, strength_name_, unit_strength_};
  for (const FoldsOutcome& outcome : outcomes) {
    solvers_.push_back(solver_of(outcome, presses_, division));
  }
  // The truths are the same for all solvers.
  for (const PressSolver& solver : solvers_) {
    if (solver.held_out.empty() || middle_.presses >= solver.held_out.size()) continue;
    std::vector<HeldOutPress> guessed = solver.held_out;
    double mean = 0;
    for (HeldOutPress& press : guessed) {
      press.found_mm = middle;
      mean += press.strength / static_cast<double>(guessed.size());
    }
    for (HeldOutPress& press : guessed) press.found_strength = mean;
    Held held;
    for (const HeldOutPress& press : guessed) held.push_back(&press);
    middle_ = errors_of(held, middle, "", "middle");
    mean_strength_ = strength_error(held, division, "middle");
  }
}

json Presses::summary() const {
  json out = {{"file", file_},
              {"folds", folds_},
              {"presses", presses_},
              {"middle", json_of(middle_)},
              {"solvers", json::object()}};
  if (!strength_name_.empty()) {
    out["strength"] = strength_name_;
    out["mean_strength_error"] = to_json(mean_strength_);
  }
  for (const PressSolver& solver : solvers_) {
    json& one = out["solvers"][solver.label];
    one = json::object();
    if (!solver.failure.empty()) one["failure"] = solver.failure;
    for (const PressLevel& level : solver.levels) {
      one["after"][std::to_string(level.presses)] = json_of(level);
    }
  }
  return out;
}

std::vector<ReportSection> Presses::report(const std::string& title,
                                           const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Presses (D.1 on measured frames)";
  section.text =
      "Distance of the contact found from the place that was pressed, on presses that the solver "
      "has not seen: the frames of " +
      file_ + " in " + std::to_string(folds_) +
      " folds. A solver that images is read by the strongest contact of its image. A press that no "
      "contact was found for counts as guessed in the middle of the sheet. Intervals: 95 %, by the "
      "bootstrap over presses.";
  if (!strength_name_.empty()) {
    section.text += " " + strength_name_ +
                    " is read from the contact's strength, in which the targets are linear.";
  }
  TableSection table;
  table.caption = "after " + std::to_string(presses_.back()) + " presses; errors in mm";
  table.columns = {{"solver", Align::left}, {"mean"}, {"median"}, {"95 %"}, {"worst"}, {"missed"}};
  if (!strength_name_.empty()) table.columns.push_back({"|error| of " + strength_name_});
  const auto add = [&](const std::string& label, const PressErrors& errors,
                       const std::optional<Estimate>& strength) {
    std::vector<Cell> row = {label};
    for (Cell& cell : error_cells(errors)) row.push_back(std::move(cell));
    if (!strength_name_.empty()) row.push_back(estimate_cell(strength, 2));
    table.rows.push_back(std::move(row));
  };
  for (const PressSolver& solver : solvers_) {
    const PressLevel& level = solver.levels.back();
    add(solver.label, level.all, level.strength);
    if (!level.failure.empty()) {
      table.rows.back()[0].lines.push_back(one_line(level.failure, 80));
    }
  }
  add("middle of the sheet", middle_, mean_strength_);
  section.tables.push_back(table);

  TableSection parts;
  parts.caption = "the same by strength and by distance from the middle";
  parts.columns = {{"solver", Align::left},
                   {"presses", Align::left},
                   {"mean"},
                   {"median"},
                   {"95 %"},
                   {"worst"},
                   {"missed"}};
  TableSection rows;
  rows.columns = {{"solver", Align::left}, {"presses"}, {"part", Align::left}};
  for (const char* name : {"mean_mm", "median_mm", "p95_mm"}) {
    for (const Column& column : exact_columns(name)) rows.columns.push_back(column);
  }
  rows.columns.insert(rows.columns.end(), {{"worst_mm"}, {"missed"}, {"held_out"}});
  for (const Column& column : exact_columns("strength_error")) rows.columns.push_back(column);
  const auto add_exact = [&](const std::string& label, std::uint64_t learned_from,
                             const PressErrors& errors, const std::optional<Estimate>& strength) {
    std::vector<Cell> row = {label, std::to_string(learned_from),
                             errors.title.empty() ? "all" : errors.title};
    for (const auto& estimate : {errors.mean, errors.median, errors.p95}) {
      for (const Cell& cell : exact_cells(estimate)) row.push_back(cell);
    }
    row.push_back(exact_cell(errors.worst));
    row.emplace_back(std::to_string(errors.missed));
    row.emplace_back(std::to_string(errors.presses));
    for (const Cell& cell : exact_cells(strength)) row.push_back(cell);
    rows.rows.push_back(std::move(row));
  };
  add_exact("middle of the sheet", 0, middle_, mean_strength_);
  for (const PressSolver& solver : solvers_) {
    for (const PressLevel& level : solver.levels) {
      add_exact(solver.label, level.presses, level.all, level.strength);
      for (const auto* division : {&level.by_strength, &level.by_place}) {
        for (const PressErrors& part : *division) {
          add_exact(solver.label, level.presses, part, std::nullopt);
          if (&level != &solver.levels.back()) continue;
          std::vector<Cell> row = {solver.label, part.title};
          for (Cell& cell : error_cells(part)) row.push_back(std::move(cell));
          parts.rows.push_back(std::move(row));
        }
      }
    }
  }
  if (!parts.rows.empty()) section.tables.push_back(parts);
  section.figures.push_back(press_curve(solvers_, middle_, title, folder / "presses_curve"));
  section.figures.push_back(
      press_map(solvers_, {border_mm_, electrodes_mm_, radius_mm_}, title, folder / "presses_map"));
  write_study_tables({title, section.text, section.tables, {}, {}}, rows, folder, "presses");
  return {section};
}

}  // namespace ertbench
