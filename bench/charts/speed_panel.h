#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/analysis/speed_accuracy.h"
#include "bench/plot/label_layout.h"

namespace ertbench {

/// A logarithmic scale across a panel.
struct LogAxis {
  double low = 1;
  double high = 10;

  double place(double value, const Box& panel) const;  ///< px
};

/// The scale of the errors, up a panel. Reaches a little above the error of doing nothing, or three
/// times the median where that has none: what is worse is shown at the upper edge.
struct ErrorAxis {
  double low = 0;
  double high = 1;

  static ErrorAxis of(const SpeedAccuracy& chart);
  bool holds(double value) const { return value <= high; }
  double place(double value, const Box& panel) const;  ///< px
};

/// One of the two panels of the chart of speed and accuracy, both with the same scale of errors.
struct SpeedPanel {
  Box box;
  LogAxis axis;
  ErrorAxis errors;
  std::string title;
  std::string x_label;
  std::string tics;
  std::vector<std::optional<double>> x;  ///< [points] µs or frames per second
  bool SpeedPoint::*frontier;
  bool batches;  ///< whether frames per second run across, the better end on the right

  bool shows(const SpeedAccuracy& chart, std::size_t point) const {
    return x[point] && chart.points[point].error;
  }
  double x_of(std::size_t point) const { return axis.place(*x[point], box); }  ///< px
  double y_of(double error) const { return errors.place(error, box); }         ///< px
};

SpeedPanel latency_panel(const SpeedAccuracy& chart, const Box& box);
SpeedPanel batch_panel(const SpeedAccuracy& chart, const Box& box);

/// The corners of the frontier, from the upper edge to the far side, in the panel's units.
std::vector<std::pair<double, double>> staircase(const SpeedAccuracy& chart,
                                                 const SpeedPanel& panel);

/// What labels must leave free: the marks, their whiskers and the staircase; px.
std::vector<Box> occupied(const SpeedAccuracy& chart, const SpeedPanel& panel);

/// The labels in the order in which they deserve a place: the frontier and the right sizes, each
/// family that has no name yet, then what failed or lies beyond the scale.
std::vector<PointLabel> labels_of(const SpeedAccuracy& chart, const SpeedPanel& panel);

}  // namespace ertbench
