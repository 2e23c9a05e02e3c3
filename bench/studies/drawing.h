#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/studies/error_statistics.h"

/// Parts that several studies' figures are made of.
namespace ertbench {

/// Panels of one size in rows, px.
struct PanelGrid {
  int panels = 1;
  int most_columns = 4;
  double left = 44;
  double top = 54;
  double width = 220;
  double height = 220;
  double gap_x = 44;
  double gap_y = 50;

  int columns() const { return std::min(panels, most_columns); }
  int rows() const { return (panels + columns() - 1) / columns(); }
  double right() const { return left + columns() * (width + gap_x); }  ///< with a gap
  double bottom() const { return top + rows() * (height + gap_y); }    ///< with a gap
  Box box(int panel) const {
    return Box::sized(left + panel % columns() * (width + gap_x),
                      top + panel / columns() * (height + gap_y), width, height);
  }
};

/// Places as the points of a panel, from `origin`.
Points points_of(const std::vector<Eigen::Vector2d>& places,
                 const Eigen::Vector2d& origin = Eigen::Vector2d::Zero());

/// A line of small print at the foot of a figure.
void add_footnote(Canvas& canvas, const std::string& text, double left);
/// Says in the middle of a panel why it is empty; nothing where `failure` is empty.
void add_failure(Canvas& canvas, const Box& box, const std::string& failure);

/// One method's points with their intervals.
struct Series {
  Points points;
  std::vector<Whisker> whiskers;

  /// Nothing where there is no estimate.
  void add(double x, const std::optional<Estimate>& estimate);
  /// Whiskers in `whisker`'s style below the line and the marks.
  void draw(Panel& panel, const LineStyle& line, const MarkStyle& mark,
            const LineStyle& whisker) const;
};

}  // namespace ertbench
