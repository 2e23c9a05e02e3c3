#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/speed/speed_chart.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr double mark_radius = 5;  ///< px
constexpr double ring_radius = 9;
constexpr std::size_t most_named = 3;  ///< families of at most this size have all points named

/// The vertical axis. It reaches a little above the error of the image without contact, or three
/// times the median of the methods if that is unknown; larger errors are drawn at the upper edge.
Axis error_axis(const SpeedAccuracy& chart) {
  Span shown{INFINITY, 0};
  std::vector<double> errors;
  for (const SpeedPoint& point : chart.points) {
    if (!point.error) continue;
    errors.push_back(*point.error);
    shown.extend(point.error_ci95 ? point.error_ci95->low : *point.error);
    shown.extend(point.error_ci95 ? point.error_ci95->high : *point.error);
  }
  if (shown.high == 0) return Axis::even({0, 1});
  if (chart.limit) {
    shown.low = std::min(shown.low, chart.limit_ci95 ? chart.limit_ci95->low : *chart.limit);
  }
  Span span{0.85 * shown.low, shown.high + 0.08 * (shown.high - 0.85 * shown.low)};
  const double limit = 1.12 * chart.nothing.value_or(3 * median(errors));
  if (span.high > 0.85 * limit) span.high = limit;
  if (span.low < 0.4 * span.high) span.low = 0;
  return Axis::even(span);
}

/// The points of one family in the order of the experiment, in the panel's units.
struct FamilyLine {
  std::size_t first = 0;  ///< index of its first point
  Points points;
};

std::vector<FamilyLine> family_lines(const SpeedAccuracy& chart, const SpeedPanel& panel) {
  std::vector<FamilyLine> out;
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    if (!panel.shows(chart, i)) continue;
    const SpeedPoint& point = chart.points[i];
    const auto [place, is_new] = places.emplace(point.family, out.size());
    if (is_new) out.push_back({i, {}});
    const double far_above = 3 * panel.errors.high;
    out[place->second].points.emplace_back(*panel.x[i], std::min(*point.error, far_above));
  }
  return out;
}

/// Segments of the lines in px, which labels should avoid.
std::vector<Segment> segments_of(const std::vector<FamilyLine>& lines, const SpeedPanel& panel) {
  std::vector<Segment> out;
  for (const FamilyLine& line : lines) {
    for (std::size_t i = 1; i < line.points.size(); ++i) {
      const auto [x1, y1] = line.points[i - 1];
      const auto [x2, y2] = line.points[i];
      out.push_back({panel.x_of(x1), panel.y_of(y1), panel.x_of(x2), panel.y_of(y2)});
    }
  }
  return out;
}

/// Boxes in px that labels must leave free: the marks, their whiskers and the staircase.
std::vector<Box> occupied(const SpeedAccuracy& chart, const SpeedPanel& panel) {
  std::vector<Box> out;
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    if (!panel.shows(chart, i)) continue;
    const SpeedPoint& point = chart.points[i];
    const double x = panel.x_of(*panel.x[i]);
    const double y = panel.y_of(*point.error);
    const double r = point.right_size ? ring_radius : mark_radius;
    out.push_back(Box::around(x, y, r));
    if (!panel.batches) {
      out.push_back({x, y - 2, panel.x_of(point.latency->p99) + 2, y + 2});
    }
    if (point.error_ci95) {
      out.push_back(
          {x - 2, panel.y_of(point.error_ci95->high), x + 2, panel.y_of(point.error_ci95->low)});
    }
  }
  const auto steps = staircase(chart, panel);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const double x1 = panel.x_of(steps[i - 1].first);
    const double x2 = panel.x_of(steps[i].first);
    const double y1 = panel.y_of(steps[i - 1].second);
    const double y2 = panel.y_of(steps[i].second);
    out.push_back(
        {std::min(x1, x2) - 1, std::min(y1, y2) - 1, std::max(x1, x2) + 1, std::max(y1, y2) + 1});
  }
  return out;
}

// Places and sizes in px.
constexpr int width = 1100;
constexpr double top = 66;
constexpr double bottom = 496;
constexpr Box left_box{66, top, 700, bottom};
constexpr Box right_box{768, top, 1080, bottom};
constexpr double legend_top = bottom + 64;

constexpr LineStyle whisker_line{rgb(0x909090), 1};
constexpr LineStyle frontier_line{ink::dark, 1.6, 2};
constexpr LineStyle nothing_line{rgb(0x606060), 1, 3};
constexpr LineStyle limit_line{ink::alarm, 1.4};
const Colour limit_band = ink::alarm.towards_white(0.86);
constexpr double mark_size = 0.9;
constexpr MarkStyle ring{circle, ink::dark, 1.9, 1.3};
constexpr MarkStyle lost{cross, ink::alarm};

class SpeedDrawing {
 public:
  SpeedDrawing(const SpeedAccuracy& chart, const std::string& title)
      : chart_(chart),
        types_(distinct(chart.points, &SpeedPoint::type)),
        styles_(types_),
        legend_(legend()),
        canvas_(width, legend_top + legend_.height()) {
    canvas_.title(title);
  }

  void draw(const std::filesystem::path& stem) {
    plot(speed_panel(chart_, left_box, false));
    plot(speed_panel(chart_, right_box, true));
    without_numbers();
    legend_.draw(canvas_, legend_top);
    canvas_.draw(stem);
  }

 private:
  std::size_t type_index(const SpeedPoint& point) const {
    return static_cast<std::size_t>(std::ranges::find(types_, point.type) - types_.begin());
  }
  MarkStyle mark(std::size_t type, Standing standing) const {
    MarkStyle out = standing == Standing::ok ? styles_.filled_mark(type, mark_size)
                                             : styles_.hollow_mark(type, mark_size);
    if (standing == Standing::failed) out.shape = cross;
    return out;
  }

  void plot(const SpeedPanel& shown) {
    Panel panel(canvas_, shown.box, shown.axis, shown.errors);
    panel.title(shown.title);
    if (chart_.nothing && shown.holds(*chart_.nothing)) panel.level(*chart_.nothing, nothing_line);
    if (chart_.limit) {
      if (chart_.limit_ci95) {
        panel.band(chart_.limit_ci95->low, chart_.limit_ci95->high, limit_band);
      }
      panel.level(*chart_.limit, limit_line);
    }
    const std::vector<FamilyLine> families = family_lines(chart_, shown);
    for (const FamilyLine& line : families) {
      const Colour colour = styles_.colour(type_index(chart_.points[line.first]));
      panel.line(line.points, {colour.towards_white(0.55), 1.2});
    }
    panel.line(staircase(chart_, shown), frontier_line);
    add_whiskers(shown, panel);
    add_marks(shown, panel);
    panel.draw();
    write_labels(shown, panel, segments_of(families, shown));
  }

  void add_whiskers(const SpeedPanel& shown, Panel& panel) const {
    std::vector<Whisker> times;
    std::vector<Whisker> errors;
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      const SpeedPoint& point = chart_.points[i];
      if (!shown.shows(chart_, i) || !shown.holds(*point.error)) continue;
      const double x = *shown.x[i];
      if (!shown.batches) times.push_back({*point.error, x, point.latency->p99});
      if (point.error_ci95) errors.push_back({x, point.error_ci95->low, point.error_ci95->high});
    }
    panel.whiskers_across(times, whisker_line);
    panel.whiskers(errors, whisker_line);
  }

  void add_marks(const SpeedPanel& shown, Panel& panel) const {
    std::map<std::pair<std::size_t, Standing>, Points> marks;
    Points rings;
    Points beyond;
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!shown.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      if (!shown.holds(*point.error)) {
        beyond.emplace_back(*shown.x[i], shown.errors.high);
        continue;
      }
      marks[{type_index(point), point.standing}].emplace_back(*shown.x[i], *point.error);
      if (point.right_size) rings.emplace_back(*shown.x[i], *point.error);
    }
    for (const auto& [kind, points] : marks) panel.marks(points, mark(kind.first, kind.second));
    panel.marks(rings, ring);
    panel.marks(beyond, lost);
  }

  std::string limit_text() const {
    std::string text = "the best known estimator, of the first " +
                       std::to_string(chart_.limit_frames) + " frames (band: 95 %)";
    if (chart_.limit_unresolved > 0) {
      text += "; " + std::to_string(chart_.limit_unresolved) + " of them unresolved";
    }
    return text;
  }

  void write_labels(const SpeedPanel& shown, Panel& panel, std::vector<Segment> lines) {
    std::vector<Box> taken = occupied(chart_, shown);
    if (!shown.batches && chart_.nothing && shown.holds(*chart_.nothing)) {
      const double y = shown.y_of(*chart_.nothing);
      canvas_.text("an empty image", shown.box.right - 4, y - 8,
                   {.size = 9, .align = TextAlign::right, .colour = nothing_line.colour});
      taken.push_back({shown.box.right - 110, y - 15, shown.box.right, y + 1});
    }
    // Below the limit only its own label may stand: any other would read as better than the limit.
    if (chart_.limit) {
      const double y = shown.y_of(*chart_.limit);
      if (!shown.batches) {
        const bool has_room = shown.box.bottom - y > 16;
        const double text_y = has_room ? y + 8 : y - 8;
        canvas_.text(limit_text(), shown.box.right - 4, text_y,
                     {.size = 9, .align = TextAlign::right, .colour = limit_line.colour});
        taken.push_back({shown.box.right - 490, text_y - 8, shown.box.right, text_y + 8});
      }
      taken.push_back({shown.box.left, y - 2, shown.box.right, shown.box.bottom});
    }
    if (chart_.nothing) {
      const double y = shown.y_of(*chart_.nothing);
      lines.push_back({shown.box.left, y, shown.box.right, y});
    }
    const auto colour_of = [this](const SpeedPoint& point) {
      return styles_.colour(type_index(point)).for_text();
    };
    panel.labels(labels_of(chart_, shown, colour_of), taken, lines);
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!shown.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      canvas_.tooltip_at(shown.x_of(*shown.x[i]), shown.y_of(*point.error),
                         description(point, chart_));
    }
  }

  /// Lists configurations without numbers in the upper right corner, which is empty.
  void without_numbers() {
    constexpr TextStyle style{.align = TextAlign::right, .colour = ink::alarm};
    double y = top + 12;
    for (const SpeedPoint& point : chart_.points) {
      if (point.measured()) continue;
      const std::string remark = point.remark.empty() ? "no time" : point.remark;
      canvas_.text("✕ " + one_line(point.label + ": " + remark, 60), left_box.right - 4, y, style);
      y += style.size + 4;
    }
  }

  Legend legend() const {
    Legend legend(left_box.left, width - 20);
    for (std::size_t t = 0; t < types_.size(); ++t) {
      if (!types_[t].empty()) legend.add({types_[t], {}, mark(t, Standing::ok)});
    }
    legend.new_line();
    legend.add({"hollow: over 1 % of the frames not converged; never on the frontier",
                {},
                MarkStyle{circle, ink::dark}});
    legend.add({"failed, or error beyond the scale", {}, lost});
    legend.new_line();
    legend.add({"frontier: nothing faster has a smaller error", frontier_line});
    if (!chart_.right_sizes.empty()) {
      legend.add({"smallest of its family within " + fixed(100 * chart_.right_sizing->margin, 0) +
                      " % of its least validation error",
                  {},
                  ring});
    }
    legend.add({"vertical bar: 95 % interval of the mean"});
    return legend;
  }

  const SpeedAccuracy& chart_;
  std::vector<std::string> types_;
  MethodStyles styles_;
  Legend legend_;
  Canvas canvas_;
};

}  // namespace

SpeedPanel speed_panel(const SpeedAccuracy& chart, const Box& box, bool batches) {
  SpeedPanel panel{box,
                   {},
                   error_axis(chart),
                   batches ? "throughput, one thread: lower right is better"
                           : "latency of one frame, one thread: lower left is better",
                   {},
                   batches ? &SpeedPoint::batch_frontier : &SpeedPoint::frontier,
                   batches};
  if (!batches) panel.errors.title = "mean " + axis_title(chart.metric);
  Span shown;
  for (const SpeedPoint& point : chart.points) {
    panel.x.push_back(batches ? point.frames_per_s
                              : member_of(point.latency, &LatencySummary::p50));
    if (!panel.x.back() || !point.error) continue;
    shown.extend(*panel.x.back());
    if (!batches) shown.extend(point.latency->p99);
  }
  panel.axis = {1, 10, true, batches ? rate_ticks() : time_ticks(),
                batches ? "frames per second, " + std::to_string(chart.batch) + " at a time"
                        : "time of one frame, p50 with a whisker to p99"};
  if (!shown.empty()) {
    panel.axis.low = shown.low / 1.6;
    panel.axis.high = shown.high * 1.6;
  }
  return panel;
}

Points staircase(const SpeedAccuracy& chart, const SpeedPanel& panel) {
  Points corners;
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    const SpeedPoint& point = chart.points[i];
    if (point.*panel.frontier) corners.emplace_back(*panel.x[i], *point.error);
  }
  std::ranges::sort(corners);
  if (panel.batches) std::ranges::reverse(corners);
  Points steps;
  double level = panel.errors.high;
  for (const auto& [x, error] : corners) {
    steps.emplace_back(x, level);
    steps.emplace_back(x, error);
    level = error;
  }
  if (!steps.empty()) steps.emplace_back(panel.batches ? panel.axis.low : panel.axis.high, level);
  return steps;
}

std::vector<PointLabel> labels_of(const SpeedAccuracy& chart, const SpeedPanel& panel,
                                  const std::function<Colour(const SpeedPoint&)>& colour_of) {
  std::vector<PointLabel> labels;
  std::vector<std::string> named;
  std::map<std::string, std::vector<std::size_t>> candidates;  // by family
  const auto add = [&](std::size_t i, const std::string& text) {
    labels.push_back({text, panel.x_of(*panel.x[i]), panel.y_of(*chart.points[i].error),
                      colour_of(chart.points[i])});
    named.push_back(chart.points[i].family);
  };
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    const SpeedPoint& point = chart.points[i];
    const bool marked = point.*panel.frontier || (!panel.batches && point.right_size);
    if (panel.shows(chart, i) && marked) candidates[point.family].push_back(i);
  }
  // A family with many points on the frontier has only its ends and its right size named, since the
  // names would pile up; tooltips show the others.
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    const auto found = candidates.find(chart.points[i].family);
    if (found == candidates.end()) continue;
    const std::vector<std::size_t>& own = found->second;
    if (!contains(own, i)) continue;
    const bool end = i == own.front() || i == own.back();
    if (own.size() <= most_named || end || chart.points[i].right_size) {
      add(i, chart.points[i].label);
    }
  }
  std::vector<std::size_t> by_error(chart.points.size());
  std::iota(by_error.begin(), by_error.end(), std::size_t{0});
  std::ranges::stable_sort(by_error, {},
                           [&](std::size_t i) { return chart.points[i].error.value_or(INFINITY); });
  for (const std::size_t i : by_error) {
    const std::string& family = chart.points[i].family;
    if (panel.shows(chart, i) && !contains(named, family)) add(i, family);
  }
  if (panel.batches) return labels;
  std::map<std::string, std::vector<std::size_t>> beyond;  // by family
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    const SpeedPoint& point = chart.points[i];
    if (!panel.shows(chart, i)) continue;
    if (!panel.holds(*point.error)) {
      beyond[point.family].push_back(i);
    } else if (point.standing == Standing::failed) {
      add(i, point.label + ": " + point.remark);
    }
  }
  for (const auto& [family, points] : beyond) {
    if (points.size() < most_named) {
      for (const std::size_t i : points) {
        add(i, chart.points[i].label + ": " + three_digits(*chart.points[i].error));
      }
      continue;
    }
    const auto error_of = [&chart](std::size_t i) { return *chart.points[i].error; };
    const auto [least, most] = std::ranges::minmax(points, {}, error_of);
    const std::size_t last =
        std::ranges::max(points, {}, [&](std::size_t i) { return *panel.x[i]; });
    add(last, family + ", " + std::to_string(points.size()) + " settings: " +
                  three_digits(error_of(least)) + " to " + three_digits(error_of(most)));
  }
  return labels;
}

void draw_speed_figure(const SpeedAccuracy& chart, const std::string& title,
                       const std::filesystem::path& stem) {
  SpeedDrawing(chart, title).draw(stem);
}

}  // namespace ertbench
