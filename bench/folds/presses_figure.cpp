#include <algorithm>
#include <cmath>

#include "bench/folds/presses.h"
#include "bench/studies/drawing.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

bool has_errors(const PressLevel& level) { return level.all.mean.has_value(); }

/// The span of the curve's values, with some room.
Span curve_span(const PressResults& results) {
  Span span;
  if (results.middle.mean) span.extend(results.middle.mean->value);
  for (const PressSolver& solver : results.solvers) {
    for (const PressLevel& level : solver.levels) {
      for (const double mean : level.fold_means) span.extend(std::max(0.01, mean));
    }
  }
  return log_span(span, 1.3);
}

void draw_curve(const PressResults& results, const std::string& heading,
                const std::filesystem::path& stem) {
  const std::vector<PressSolver>& solvers = results.solvers;
  constexpr double width = 700;
  constexpr double height = 380;
  constexpr double left = 64;
  const MethodStyles styles = styles_of(solvers);
  Legend legend(left, left + width);
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    legend.add({solvers[s].label, styles.line(s, 1.6), styles.mark(s, 0.9)});
  }
  const LineStyle guess{ink::black, 1.4, 2};
  legend.add({"the middle of the sheet, always", guess});
  Canvas canvas(left + width + 20, 40 + height + 80 + legend.height());
  canvas.title(heading);
  const Box box = Box::sized(left, 40, width, height);
  Span across;
  std::vector<Tick> ticks;
  for (const PressLevel& level : solvers.front().levels) {
    across.extend(static_cast<double>(level.presses));
    ticks.push_back({static_cast<double>(level.presses), std::to_string(level.presses)});
  }
  Axis x = Axis::logarithms({across.low / 1.15, across.high * 1.15}, "presses learned from");
  x.ticks = ticks;
  Panel axes(canvas, box, x, Axis::logarithms(curve_span(results), "localisation error, mm"));
  if (results.middle.mean) axes.level(results.middle.mean->value, guess);
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    // Side by side, so that no band hides another.
    const double shift =
        std::pow(1.012, static_cast<double>(s) - (static_cast<double>(solvers.size()) - 1) / 2);
    Points means;
    std::vector<Whisker> bands;
    for (const PressLevel& level : solvers[s].levels) {
      if (!has_errors(level)) continue;
      const double at = shift * static_cast<double>(level.presses);
      const double mean = std::max(0.01, level.all.mean->value);
      means.emplace_back(at, mean);
      const auto [low, high] =
          std::minmax_element(level.fold_means.begin(), level.fold_means.end());
      bands.push_back({at, std::max(0.01, *low), std::max(0.01, *high)});
      axes.tooltip(at, mean,
                   solvers[s].label + "\n" + std::to_string(level.presses) + " presses\nmean " +
                       fixed(mean, 2) + " mm, folds " + fixed(*low, 2) + " to " + fixed(*high, 2));
    }
    axes.line(means, styles.line(s, 1.6));
    axes.whiskers(bands, {styles.colour(s), 1.2});
    axes.marks(means, styles.mark(s, 0.9));
  }
  axes.draw();
  legend.draw(canvas, box.bottom + 56);
  add_footnote(
      canvas,
      "marks: mean over all presses, each held out once; bars: least and largest mean of a fold",
      left);
  canvas.draw(stem);
}

/// A shaft and two barbs.
Points arrow(const Vector2d& from, const Vector2d& to) {
  const Vector2d along = to - from;
  const double length = along.norm();
  if (!(length > 0)) return {};
  const Vector2d back = along / length * std::min(2.5, 0.5 * length);
  const Vector2d side(-back.y(), back.x());
  return points_of({from, to, to - back + 0.5 * side, to, to - back - 0.5 * side});
}

void draw_map(const PressResults& results, const std::string& heading,
              const std::filesystem::path& stem) {
  const std::vector<PressSolver>& solvers = results.solvers;
  const PanelGrid grid{.panels = static_cast<int>(solvers.size()),
                       .most_columns = 3,
                       .left = 48,
                       .width = 300,
                       .height = 300,
                       .gap_x = 54,
                       .gap_y = 54};
  Canvas canvas(grid.right(), grid.bottom() + 46);
  canvas.title(heading + ": places in mm from the sheet's centre");
  const Span span{-1.05 * results.radius_mm, 1.05 * results.radius_mm};
  const MarkStyle truth{7, ink::black, 0.3, 1};
  const LineStyle shaft{hue(1), 1.1};
  const MarkStyle electrode{5, ink::dark, 0.7, 1};
  const MarkStyle none{cross, ink::alarm, 0.6, 1.4};
  int panel = 0;
  for (const PressSolver& solver : solvers) {
    const Box box = grid.box(panel++);
    Panel axes(canvas, box, Axis::even(span), Axis::even(span));
    const auto& mean = solver.levels.back().all.mean;
    axes.title(solver.label + (mean ? ", mean " + fixed(mean->value, 1) + " mm" : std::string()));
    add_failure(canvas, box, solver.failure, 44);
    axes.line(points_of(results.border_mm), {ink::light, 1.2});
    axes.marks(points_of(results.electrodes_mm), electrode);
    std::vector<Vector2d> places;
    std::vector<Vector2d> missed;
    for (const HeldOutPress& press : solver.held_out) {
      (press.found_mm ? places : missed).push_back(press.place_mm);
      if (press.found_mm) axes.line(arrow(press.place_mm, *press.found_mm), shaft);
    }
    axes.marks(points_of(places), truth);
    axes.marks(points_of(missed), none);
    axes.draw();
  }
  Legend legend(grid.left, grid.right() - 20);
  legend.add({"pressed", {}, truth});
  legend.add({"from there to the estimated position", shaft});
  legend.add({"missed", {}, none});
  legend.add({"electrode", {}, electrode});
  legend.draw(canvas, canvas.height() - 24);
  canvas.draw(stem);
}

}  // namespace

StudyFigure press_curve(const std::shared_ptr<const PressResults>& results) {
  return {
      "_curve", "Error by the number of presses",
      "mean localisation error on presses that were not learned from", "",
      [results](const auto& heading, const auto& stem) { draw_curve(*results, heading, stem); }};
}

StudyFigure press_map(const std::shared_ptr<const PressResults>& results) {
  return {"_map", "True and estimated positions",
          "every press where it was held out; axes in mm from the sheet's centre", "",
          [results](const auto& heading, const auto& stem) { draw_map(*results, heading, stem); }};
}

}  // namespace ertbench
