#include "bench/studies/localisation.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bench/studies/columns.h"
#include "bench/studies/drawing.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

std::optional<Vector2d> place_by(PlaceRule rule, const FrameReading& reading) {
  if (rule == PlaceRule::raw) return reading.centroid_mm;
  if (rule == PlaceRule::thresholded) return reading.centroid25_mm;
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

using Rule = PlaceErrors::Rule;
using ErrorColumn = StudyColumn<Rule>;

const StudyColumns<Rule> error_columns = {
    ErrorColumn::estimate("mean_mm", &Rule::mean, 2).table("mean"),
    ErrorColumn::estimate("median_mm", &Rule::median, 2).table("median"),
    ErrorColumn::estimate("p95_mm", &Rule::p95, 2).table("95 %"),
    ErrorColumn::number("worst_mm", &Rule::worst, 1).table("worst"),
    ErrorColumn::count("undefined_frames", &Rule::undefined)
        .table("undefined frames")
        .data("undefined")};

const Rule& rule_of(const PlaceErrors& solver, PlaceRule rule) {
  return solver.rules[static_cast<std::size_t>(rule)];
}

/// Statistics of the bound over the places, which have no intervals.
Rule bound_errors(const LocalisedSet& set) {
  const SortedValues bounds = set.bound_mm;
  return {Estimate::exact(mean(set.bound_mm)), Estimate::exact(median(bounds)),
          Estimate::exact(interpolated_quantile(bounds, 0.95)), bounds.largest(), std::nullopt};
}

/// Adds the set's table, CSV rows, numbers and headlines; with `places` the numbers of each place.
void add_set(const LocalisedSet& set, const std::string& law, bool places, TableSection& rows,
             Study& study) {
  const std::string frames = std::to_string(set.frames);
  TableSection& table = study.sections.front().report.tables.emplace_back();
  table.caption = set.name + ": " + set.condition + ", " + law + " law, " +
                  std::to_string(set.places.size()) + " places, " + frames +
                  " frames; errors in mm";
  table.columns = error_columns.titles({{"solver", Align::left}, {"place by", Align::left}});
  json& numbers =
      study.numbers["sets"][set.name] = {{"condition", set.condition}, {"frames", set.frames}};
  for (const PlaceErrors& solver : set.solvers) {
    const bool failed = add_failed(solver.label, solver.failure, table);
    json& own = numbers["solvers"][solver.label];
    if (failed) own = {{"failure", solver.failure}};
    for (const PlaceRule rule : kPlaceRules) {
      const std::string by = name_of(rule);
      const Rule& errors = rule_of(solver, rule);
      rows.rows.push_back(error_columns.data({set.name, solver.label, by}, errors));
      rows.rows.back().emplace_back(frames);
      if (failed) continue;
      table.rows.push_back(
          error_columns.cells({rule == PlaceRule::raw ? solver.label : "", by}, errors));
      own[by] = error_columns.json(errors);
      if (rule == PlaceRule::raw) continue;
      study.best.push_back(
          {solver.label, set.name + ": median error, " + by + " (mm)", 2, value_of(errors.median)});
    }
    for (std::size_t place = 0; places && !failed && place < set.places.size(); ++place) {
      const auto& found = solver.found[place];
      own["places"].push_back({{"target_mm", {set.places[place].x(), set.places[place].y()}},
                               {"found_mm", found ? json{found->x(), found->y()} : json()},
                               {"scatter_mm", solver.scatter_mm[place]}});
    }
  }
  if (set.bound_mm.empty()) return;
  const Rule bound = bound_errors(set);
  table.rows.push_back(error_columns.cells({"Cramér–Rao", "bound of the rms error"}, bound));
  rows.rows.push_back(error_columns.data({set.name, "Cramér–Rao", "bound"}, bound));
  rows.rows.back().emplace_back();
  numbers["cramer_rao_mm"] = {{"mean", bound.mean->value},
                              {"median", bound.median->value},
                              {"p95", bound.p95->value},
                              {"worst", *bound.worst},
                              {"places", set.bound_mm}};
}

Points circle_around(const Vector2d& centre, double radius) {
  Points out;
  constexpr int corners = 20;
  for (int i = 0; i <= corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    out.emplace_back(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle));
  }
  return out;
}

void draw_map(const LocalisedSet& set, double side_mm, const std::string& heading,
              const std::filesystem::path& stem) {
  const MarkStyle target{7, ink::black, 0.35, 1};
  const MarkStyle found{cross, hue(1), 0.55, 1.5};
  const LineStyle scatter{ink::light, 0.8};
  const LineStyle bound{hue(2), 1.4};
  const bool bounded = !set.bound_mm.empty();
  const PanelGrid grid{.panels = static_cast<int>(set.solvers.size()) + bounded};
  Canvas canvas(grid.right(), grid.bottom() + 34);
  canvas.title(heading);
  const Span span{-side_mm / 2, side_mm / 2};
  int next = 0;
  const auto panel = [&](const std::string& title) {
    Panel out(canvas, grid.box(next++), Axis::even(span), Axis::even(span));
    out.title(title);
    return out;
  };
  for (const PlaceErrors& solver : set.solvers) {
    const auto& median = rule_of(solver, PlaceRule::thresholded).median;
    Panel axes = panel(solver.label +
                       (median ? ", median " + fixed(median->value, 1) + " mm" : std::string()));
    add_failure(canvas, axes.box(), solver.failure);
    std::vector<Vector2d> means;
    for (std::size_t p = 0; p < solver.found.size(); ++p) {
      if (!solver.found[p]) continue;
      axes.line(circle_around(*solver.found[p], solver.scatter_mm[p]), scatter);
    }
    for (std::size_t p = 0; p < solver.found.size(); ++p) {
      if (!solver.found[p]) continue;
      axes.line(points_of({set.places[p], *solver.found[p]}), {found.colour, 1.2});
      means.push_back(*solver.found[p]);
    }
    axes.marks(points_of(means), found);
    axes.marks(points_of(set.places), target);
    axes.draw();
  }
  Legend legend(grid.left, grid.right() - 10);
  legend.add({"target", {}, target});
  legend.add(
      {"mean estimated position, a line from its target", LineStyle{found.colour, 1.2}, found});
  legend.add({"rms distance of single frames around it", {}, MarkStyle{6, scatter.colour, 1.2, 1}});
  if (bounded) {
    Panel axes = panel("Cramér–Rao, median " + fixed(median(set.bound_mm), 1) + " mm");
    for (std::size_t p = 0; p < set.places.size(); ++p) {
      axes.line(circle_around(set.places[p], std::min(set.bound_mm[p], span.high)), bound);
    }
    axes.marks(points_of(set.places), target);
    axes.draw();
    legend.add({"Cramér–Rao bound of the rms", {}, MarkStyle{6, bound.colour, 1.2, 1.4}});
  }
  legend.draw(canvas, canvas.height() - 30);
  canvas.draw(stem);
}

/// The targets of one set, each solver's mean estimated positions, and the bound: the
/// paper's figure D1. `side_mm`: of the sheet.
StudyFigure localisation_map(const std::shared_ptr<const LocalisedSet>& set, double side_mm,
                             const std::string& law) {
  return {"_map_" + set->name, "Targets and estimated positions, " + set->name,
          "axes in mm from the sheet's centre; " + set->condition + ", " + law +
              " law; positions by the thresholded centroid",
          ": " + set->condition + ", " + law + " law; axes in mm",
          [set, side_mm](const auto& heading, const auto& stem) {
            draw_map(*set, side_mm, heading, stem);
          }};
}

}  // namespace

const char* name_of(PlaceRule rule) {
  constexpr const char* names[] = {"raw", "thresholded", "contact"};
  return names[static_cast<std::size_t>(rule)];
}

PlaceErrors place_errors(const std::vector<Vector2d>& places,
                         const std::vector<std::size_t>& place_of,
                         const std::vector<FrameReading>& readings, const std::string& key) {
  PlaceErrors out;
  for (const PlaceRule rule : kPlaceRules) {
    Rule& statistics = out.rules[static_cast<std::size_t>(rule)];
    GroupedErrors errors(places.size());
    std::vector<std::vector<Vector2d>> found(places.size());
    for (std::size_t frame = 0; frame < readings.size(); ++frame) {
      const std::size_t place = place_of[frame];
      const auto at = place_by(rule, readings[frame]);
      if (!at) {
        ++*statistics.undefined;
        continue;
      }
      errors.add(place, (*at - places[place]).norm());
      found[place].push_back(*at);
    }
    const std::string name = key + name_of(rule);
    statistics.mean = errors.mean(name + "mean");
    statistics.median = errors.quantile(0.5, name + "median");
    statistics.p95 = errors.quantile(0.95, name + "p95");
    statistics.worst = errors.worst();
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

Study localisation_study(const StudyInput& input) {
  const std::string law = input.law();
  const auto sets = std::make_shared<std::vector<LocalisedSet>>();
  for (const std::string& set : input.spec.sets) sets->push_back(localised_set(input, set));

  Study study(input.spec.name, "Localisation (D.1)", {{"law", law}});
  StudySection& section = study.sections.front();
  section.report.text =
      "Distance of the place that is read out of the image from the middle of the touch. Raw: the "
      "centroid of the whole image. Thresholded: after everything under 25 % of the largest value "
      "is set to zero, as in D.1. Contact: the strongest contact that was found. Intervals: 95 %, "
      "by the bootstrap over places. The Cramér–Rao bound is the least root mean square error of "
      "any unbiased estimate that knows the indenter and neither place nor force; a method that "
      "knows more, or is biased, may fall below it.";
  TableSection rows;
  rows.columns =
      error_columns.names({{"set", Align::left}, {"solver", Align::left}, {"rule", Align::left}});
  rows.columns.emplace_back("frames");
  for (const LocalisedSet& set : *sets) {
    const bool mapped = contains(input.spec.maps, set.name);
    add_set(set, law, mapped, rows, study);
    const double side_mm = input.experiment.sensor.sheet->size_mm().x();
    if (mapped) section.figures.push_back(localisation_map({sets, &set}, side_mm, law));
  }
  section.data = {{"", rows}};
  return study;
}

}  // namespace ertbench
