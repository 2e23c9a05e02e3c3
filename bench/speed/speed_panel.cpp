#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "bench/speed/speed_accuracy.h"
#include "bench/speed/speed_figure.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr double mark_radius = 5;  ///< px
constexpr double ring_radius = 9;
constexpr std::size_t most_named = 3;  ///< families of at most this size have all points named

/// A logarithmic axis around the values.
Axis axis_around(const std::vector<double>& values, std::vector<Tick> ticks, std::string title) {
  Axis axis{1, 10, true, std::move(ticks), std::move(title)};
  if (values.empty()) return axis;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  axis.low = *least / 1.6;
  axis.high = *most * 1.6;
  return axis;
}

std::vector<std::size_t> by_error(const SpeedAccuracy& chart) {
  std::vector<std::size_t> order(chart.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return chart.points[a].error.value_or(INFINITY) < chart.points[b].error.value_or(INFINITY);
  });
  return order;
}

}  // namespace

Axis error_axis(const SpeedAccuracy& chart) {
  double least = INFINITY;
  double most = 0;
  std::vector<double> errors;
  for (const SpeedPoint& point : chart.points) {
    if (!point.error) continue;
    errors.push_back(*point.error);
    least = std::min(least, point.error_ci95 ? point.error_ci95->low : *point.error);
    most = std::max(most, point.error_ci95 ? point.error_ci95->high : *point.error);
  }
  if (most == 0) return Axis::even({0, 1});
  if (chart.limit) least = std::min(least, chart.limit_ci95 ? chart.limit_ci95->low : *chart.limit);
  Span span{0.85 * least, most + 0.08 * (most - 0.85 * least)};
  const double limit = 1.12 * chart.nothing.value_or(3 * median(errors));
  if (span.high > 0.85 * limit) span.high = limit;
  if (span.low < 0.4 * span.high) span.low = 0;
  return Axis::even(span);
}

SpeedPanel latency_panel(const SpeedAccuracy& chart, const Box& box) {
  SpeedPanel panel{box,
                   {},
                   error_axis(chart),
                   "latency of one frame, one thread: lower left is better",
                   {},
                   &SpeedPoint::frontier,
                   false};
  panel.errors.title = "median " + axis_title(chart.metric);
  std::vector<double> ends;
  for (const SpeedPoint& point : chart.points) {
    panel.x.push_back(point.latency ? std::optional(point.latency->p50) : std::nullopt);
    if (point.measured()) ends.insert(ends.end(), {point.latency->p50, point.latency->p99});
  }
  panel.axis = axis_around(ends, time_ticks(), "time of one frame, p50 with a whisker to p99");
  return panel;
}

SpeedPanel batch_panel(const SpeedAccuracy& chart, const Box& box) {
  SpeedPanel panel{box,
                   {},
                   error_axis(chart),
                   "throughput, one thread: lower right is better",
                   {},
                   &SpeedPoint::batch_frontier,
                   true};
  std::vector<double> ends;
  for (const SpeedPoint& point : chart.points) {
    panel.x.push_back(point.frames_per_s);
    if (point.frames_per_s && point.error) ends.push_back(*point.frames_per_s);
  }
  panel.axis = axis_around(ends, rate_ticks(),
                           "frames per second, " + std::to_string(chart.batch) + " at a time");
  return panel;
}

std::vector<std::pair<double, double>> staircase(const SpeedAccuracy& chart,
                                                 const SpeedPanel& panel) {
  std::vector<std::pair<double, double>> corners;
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    const SpeedPoint& point = chart.points[i];
    if (point.*panel.frontier) corners.emplace_back(*panel.x[i], *point.error);
  }
  std::sort(corners.begin(), corners.end());
  if (panel.batches) std::reverse(corners.begin(), corners.end());
  std::vector<std::pair<double, double>> steps;
  double level = panel.errors.high;
  for (const auto& [x, error] : corners) {
    steps.emplace_back(x, level);
    steps.emplace_back(x, error);
    level = error;
  }
  if (!steps.empty()) steps.emplace_back(panel.batches ? panel.axis.low : panel.axis.high, level);
  return steps;
}

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
    if (std::find(own.begin(), own.end(), i) == own.end()) continue;
    const bool end = i == own.front() || i == own.back();
    if (own.size() <= most_named || end || chart.points[i].right_size) {
      add(i, chart.points[i].label);
    }
  }
  for (const std::size_t i : by_error(chart)) {
    const std::string& family = chart.points[i].family;
    if (panel.shows(chart, i) && std::find(named.begin(), named.end(), family) == named.end()) {
      add(i, family);
    }
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

}  // namespace ertbench
