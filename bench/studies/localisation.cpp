#include "bench/studies/localisation.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/report/report.h"
#include "bench/studies/study.h"
#include "core/statistics.h"
#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

std::optional<Vector2d> place_by(PlaceRule rule, const FrameReading& reading) {
  switch (rule) {
    case PlaceRule::raw:
      return reading.centroid_mm;
    case PlaceRule::thresholded:
      return reading.centroid25_mm;
    case PlaceRule::contact:
      break;
  }
  if (reading.contacts.empty()) return std::nullopt;
  return reading.contacts.front().place_mm;
}

/// Root mean square error that the bound leaves at each place.
std::vector<double> bounds_of(const DatasetSpec& spec, const TouchDistribution& touches) {
  if (!spec.noise.snr_db) return {};
  const SceneModel model(spec.sensor, spec.model);
  std::vector<double> out;
  for (int place = 0; place < touches.places->count(); ++place) {
    const Touch touch{touches.indenters.front(), touches.places->place_mm(place),
                      (touches.force_N.first + touches.force_N.second) / 2};
    const Eigen::Matrix3d covariance = touch_bound(spec, model, touch);
    out.push_back(std::sqrt(covariance(0, 0) + covariance(1, 1)));
  }
  return out;
}

LocalisedSet localised_set(const StudyInput& input, const std::string& name) {
  const DatasetSpec& spec = input.set_spec(name);
  const auto& touches = std::get<TouchDistribution>(spec.scenes);
  LocalisedSet set;
  set.name = name;
  set.condition = touches.indenters.front().text() + ", " + force_text(touches.force_N) + ", " +
                  noise_text(spec.noise);
  set.frames = spec.count;
  for (int place = 0; place < touches.places->count(); ++place) {
    set.places.push_back(touches.places->place_mm(place));
  }
  // The bound is the same whatever was trained, and headlines have none of it.
  if (input.training == 0) set.bound_mm = bounds_of(spec, touches);
  std::vector<std::size_t> place_of;
  for (std::uint64_t frame = 0; frame < spec.count; ++frame) {
    place_of.push_back(spec.scene_number(frame) % set.places.size());
  }
  for (const std::string& label : input.labels()) {
    const auto* readings = input.readings(label, name);
    PlaceErrors errors;
    if (readings) errors = place_errors(set.places, place_of, *readings, name + label);
    errors.label = label;
    if (!readings) errors.failure = input.failure(label);
    set.solvers.push_back(std::move(errors));
  }
  return set;
}

TableSection table_of(const LocalisedSet& set, const std::string& law) {
  TableSection table;
  table.caption = set.name + ": " + set.condition + ", " + law + " law, " +
                  std::to_string(set.places.size()) + " places, " + std::to_string(set.frames) +
                  " frames; errors in mm";
  table.columns = {
      {"solver", Align::left}, {"place by", Align::left}, {"mean"}, {"median"}, {"95 %"}, {"worst"},
      {"undefined frames"}};
  for (const PlaceErrors& solver : set.solvers) {
    if (!solver.failure.empty()) {
      table.rows.push_back({solver.label, solver.failure, {}, {}, {}, {}, {}});
      continue;
    }
    for (const PlaceRule rule : kPlaceRules) {
      const PlaceErrors::Rule& errors = solver.rules[static_cast<std::size_t>(rule)];
      table.rows.push_back({rule == PlaceRule::raw ? solver.label : "", name_of(rule),
                            estimate_cell(errors.mean, 2), estimate_cell(errors.median, 2),
                            estimate_cell(errors.p95, 2), number_cell(errors.worst, 1),
                            std::to_string(errors.undefined)});
    }
  }
  if (!set.bound_mm.empty()) {
    const SortedValues bounds = set.bound_mm;
    table.rows.push_back({"Cramér–Rao", "bound of the rms error",
                          number_cell(mean(set.bound_mm), 2), number_cell(median(bounds), 2),
                          number_cell(interpolated_quantile(bounds, 0.95), 2),
                          number_cell(bounds.largest(), 1), ""});
  }
  return table;
}

void append(std::vector<Cell>& row, const std::vector<Cell>& cells) {
  row.insert(row.end(), cells.begin(), cells.end());
}

/// All sets, a row a rule, for programs.
TableSection error_rows(const std::vector<LocalisedSet>& sets) {
  TableSection rows;
  rows.columns = {{"set", Align::left}, {"solver", Align::left}, {"rule", Align::left}};
  for (const char* name : {"mean_mm", "median_mm", "p95_mm"}) {
    for (const Column& column : exact_columns(name)) rows.columns.push_back(column);
  }
  rows.columns.insert(rows.columns.end(), {{"worst_mm"}, {"undefined"}, {"frames"}});
  for (const LocalisedSet& set : sets) {
    for (const PlaceErrors& solver : set.solvers) {
      for (const PlaceRule rule : kPlaceRules) {
        const PlaceErrors::Rule& errors = solver.rules[static_cast<std::size_t>(rule)];
        std::vector<Cell> row = {set.name, solver.label, name_of(rule)};
        append(row, exact_cells(errors.mean));
        append(row, exact_cells(errors.median));
        append(row, exact_cells(errors.p95));
        append(row, {exact_cell(errors.worst), std::to_string(errors.undefined),
                     std::to_string(set.frames)});
        rows.rows.push_back(std::move(row));
      }
    }
    if (set.bound_mm.empty()) continue;
    const SortedValues bounds = set.bound_mm;
    rows.rows.push_back({set.name,
                         "Cramér–Rao",
                         "bound",
                         exact_cell(mean(set.bound_mm)),
                         {},
                         {},
                         exact_cell(median(bounds)),
                         {},
                         {},
                         exact_cell(interpolated_quantile(bounds, 0.95)),
                         {},
                         {},
                         exact_cell(bounds.largest()),
                         {},
                         {}});
  }
  return rows;
}

json json_of(const PlaceErrors& solver, const LocalisedSet& set, bool places) {
  if (!solver.failure.empty()) return {{"failure", solver.failure}};
  json out;
  for (const PlaceRule rule : kPlaceRules) {
    const PlaceErrors::Rule& errors = solver.rules[static_cast<std::size_t>(rule)];
    out[name_of(rule)] = {{"mean_mm", to_json(errors.mean)},
                          {"median_mm", to_json(errors.median)},
                          {"p95_mm", to_json(errors.p95)},
                          {"worst_mm", errors.worst ? json(*errors.worst) : json()},
                          {"undefined_frames", errors.undefined}};
  }
  for (std::size_t place = 0; places && place < set.places.size(); ++place) {
    const auto& found = solver.found[place];
    out["places"].push_back({{"target_mm", {set.places[place].x(), set.places[place].y()}},
                             {"found_mm", found ? json{found->x(), found->y()} : json()},
                             {"scatter_mm", solver.scatter_mm[place]}});
  }
  return out;
}

}  // namespace

const char* name_of(PlaceRule rule) {
  switch (rule) {
    case PlaceRule::raw:
      return "raw";
    case PlaceRule::thresholded:
      return "thresholded";
    case PlaceRule::contact:
      break;
  }
  return "contact";
}

PlaceErrors place_errors(const std::vector<Vector2d>& places,
                         const std::vector<std::size_t>& place_of,
                         const std::vector<FrameReading>& readings, const std::string& key) {
  PlaceErrors out;
  for (const PlaceRule rule : kPlaceRules) {
    GroupedErrors errors(places.size());
    std::vector<std::vector<Vector2d>> found(places.size());
    for (std::size_t frame = 0; frame < readings.size(); ++frame) {
      const std::size_t place = place_of[frame];
      const auto at = place_by(rule, readings[frame]);
      if (!at) {
        errors.add_undefined();
        continue;
      }
      errors.add(place, (*at - places[place]).norm());
      found[place].push_back(*at);
    }
    const std::string name = key + name_of(rule);
    PlaceErrors::Rule& statistics = out.rules[static_cast<std::size_t>(rule)];
    statistics.mean = errors.mean(name + "mean");
    statistics.median = errors.quantile(0.5, name + "median");
    statistics.p95 = errors.quantile(0.95, name + "p95");
    statistics.worst = errors.worst();
    statistics.undefined = errors.undefined();
    if (rule != PlaceRule::thresholded) continue;
    for (const std::vector<Vector2d>& frames : found) {
      out.found.emplace_back();
      out.scatter_mm.push_back(0);
      if (frames.empty()) continue;
      Vector2d middle = Vector2d::Zero();
      for (const Vector2d& at : frames) middle += at / static_cast<double>(frames.size());
      double square = 0;
      for (const Vector2d& at : frames) square += (at - middle).squaredNorm();
      out.found.back() = middle;
      out.scatter_mm.back() = std::sqrt(square / static_cast<double>(frames.size()));
    }
  }
  return out;
}

Localisation::Localisation(const StudyInput& input)
    : name_(input.spec.name),
      law_(input.law()),
      side_mm_(input.experiment.sensor.sheet->size_mm().x()),
      maps_(input.spec.maps) {
  for (const std::string& set : input.spec.sets) sets_.push_back(localised_set(input, set));
}

json Localisation::summary() const {
  json out = {{"law", law_}};
  for (const LocalisedSet& set : sets_) {
    const bool mapped = std::find(maps_.begin(), maps_.end(), set.name) != maps_.end();
    json& one = out["sets"][set.name];
    one = {{"condition", set.condition}, {"frames", set.frames}};
    if (!set.bound_mm.empty()) {
      const SortedValues bounds = set.bound_mm;
      one["cramer_rao_mm"] = {{"mean", mean(set.bound_mm)},
                              {"median", median(bounds)},
                              {"p95", interpolated_quantile(bounds, 0.95)},
                              {"worst", bounds.largest()},
                              {"places", set.bound_mm}};
    }
    for (const PlaceErrors& solver : set.solvers) {
      one["solvers"][solver.label] = json_of(solver, set, mapped);
    }
  }
  return out;
}

std::vector<Headline> Localisation::headlines() const {
  std::vector<Headline> out;
  for (const LocalisedSet& set : sets_) {
    for (const PlaceErrors& solver : set.solvers) {
      if (!solver.failure.empty()) continue;
      for (const PlaceRule rule : {PlaceRule::thresholded, PlaceRule::contact}) {
        const auto& median = solver.rules[static_cast<std::size_t>(rule)].median;
        out.push_back({solver.label, set.name + ": median error, " + name_of(rule) + " (mm)", 2,
                       value_of(median)});
      }
    }
  }
  return out;
}

std::vector<ReportSection> Localisation::report(const std::string& title,
                                                const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Localisation (D.1)";
  section.text =
      "Distance of the place that is read out of the image from the middle of the touch. Raw: the "
      "centroid of the whole image. Thresholded: after everything under 25 % of the largest value "
      "is set to zero, as in D.1. Contact: the strongest contact that was found. Intervals: 95 %, "
      "by the bootstrap over places. The Cramér–Rao bound is the least root mean square error of "
      "any unbiased estimate that knows the indenter and neither place nor force; a method that "
      "knows more, or is biased, may fall below it.";
  for (const LocalisedSet& set : sets_) {
    section.tables.push_back(table_of(set, law_));
    if (std::find(maps_.begin(), maps_.end(), set.name) == maps_.end()) continue;
    section.figures.push_back(localisation_map(set, side_mm_, law_, without_law(title),
                                               folder / (name_ + "_map_" + set.name)));
  }
  section.figures.insert(section.figures.begin(),
                         localisation_overview(sets_, law_, without_law(title), folder / name_));
  write_study_tables({title, section.text, section.tables, {}, {}}, error_rows(sets_), folder,
                     name_);
  return {section};
}

}  // namespace ertbench
