#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/plot/label_layout.h"
#include "bench/plot/panel.h"
#include "bench/speed/speed_accuracy.h"

namespace ertbench {

/// The scale of the errors, up a panel. Reaches a little above the error of doing nothing, or three
/// times the median where that has none: what is worse is shown at the upper edge.
Axis error_axis(const SpeedAccuracy& chart);

/// One of the two panels of the chart of speed and accuracy, both with the same scale of errors.
struct SpeedPanel {
  Box box;
  Axis axis;    ///< of times or rates, across
  Axis errors;  ///< up
  std::string title;
  std::vector<std::optional<double>> x;  ///< [points] µs or frames per second
  bool SpeedPoint::*frontier;
  bool batches;  ///< whether frames per second run across, the better end on the right

  bool shows(const SpeedAccuracy& chart, std::size_t point) const {
    return x[point] && chart.points[point].error;
  }
  /// Whether the error lies on the scale and not above it.
  bool holds(double error) const { return error <= errors.high; }
  double x_of(double value) const { return box.across(axis.share(value)); }               ///< px
  double y_of(double error) const { return box.up(errors.share(errors.capped(error))); }  ///< px
};

SpeedPanel latency_panel(const SpeedAccuracy& chart, const Box& box);
SpeedPanel batch_panel(const SpeedAccuracy& chart, const Box& box);

/// The corners of the frontier, from the upper edge to the far side, in the panel's units.
std::vector<std::pair<double, double>> staircase(const SpeedAccuracy& chart,
                                                 const SpeedPanel& panel);

/// The points of a family in the order of the experiment, in the panel's units.
struct FamilyLine {
  std::size_t first = 0;  ///< index of its first point
  std::vector<std::pair<double, double>> points;
};
std::vector<FamilyLine> family_lines(const SpeedAccuracy& chart, const SpeedPanel& panel);

/// The same lines in px: what had better not run through a label.
std::vector<Segment> segments_of(const std::vector<FamilyLine>& lines, const SpeedPanel& panel);

/// What labels must leave free: the marks, their whiskers and the staircase; px.
std::vector<Box> occupied(const SpeedAccuracy& chart, const SpeedPanel& panel);

/// The labels in the order in which they deserve a place: the frontier and the right sizes, each
/// family that has no name yet, then what failed or lies beyond the scale (one name for a family of
/// which three points or more do). `colour_of`: that of a point's name.
std::vector<PointLabel> labels_of(const SpeedAccuracy& chart, const SpeedPanel& panel,
                                  const std::function<Colour(const SpeedPoint&)>& colour_of);

/// Draws `stem`.svg and `stem`.png: on the left the median error against the time of one frame (p50
/// with a whisker to p99, 95 % interval of the median), on the right against the frames per second
/// in batches. A line joins each family, a staircase the configurations that no faster one beats. A
/// configuration that failed or did not converge is hollow or, without numbers, named above the
/// chart. Throws InputError where gnuplot is missing or a file cannot be written.
void draw_speed_figure(const SpeedAccuracy& chart, const std::string& title,
                       const std::filesystem::path& stem);

}  // namespace ertbench
