#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bench/plot/axis.h"
#include "bench/plot/canvas.h"
#include "bench/plot/label_layout.h"

namespace ertbench {

/// Points (x, y) in the units of a panel's axes.
using Points = std::vector<std::pair<double, double>>;

/// An interval along one axis, at a place on the other.
struct Whisker {
  double at = 0;
  double low = 0;
  double high = 0;
};

/// A bar from zero.
struct Bar {
  double x = 0;
  double height = 0;
  Colour colour;
};

/// A pair of axes on a canvas and what is plotted between them, in the order of the calls. Nothing
/// without points is plotted.
class Panel {
 public:
  /// `canvas` must outlive the panel.
  Panel(Canvas& canvas, const Box& box, Axis x, Axis y);

  const Box& box() const { return box_; }
  double x(double value) const { return box_.across(x_.share(value)); }  ///< px
  double y(double value) const { return box_.up(y_.share(value)); }      ///< px

  /// Above the panel.
  void title(const std::string& text);

  void line(const Points& points, const LineStyle& style);
  void marks(const Points& points, const MarkStyle& style);
  /// A line from side to side at a value of the upright axis.
  void level(double value, const LineStyle& style);
  /// All from side to side between two values of the upright axis.
  void band(double low, double high, const Colour& colour);
  void whiskers(const std::vector<Whisker>& whiskers, const LineStyle& style);
  void whiskers_across(const std::vector<Whisker>& whiskers, const LineStyle& style);
  /// `width` in units of the axis across.
  void bars(const std::vector<Bar>& bars, double width);

  /// Texts near their points (px), where they meet neither each other nor `taken`, with a line to
  /// the point where that is far; one for which there is no room is left out. Where there is room,
  /// `lines` (px) do not run through them.
  void labels(const std::vector<PointLabel>& labels, const std::vector<Box>& taken,
              const std::vector<Segment>& lines = {});

  /// What the pointer shows over a point.
  void tooltip(double x_value, double y_value, std::string text);

  /// Puts the panel on the canvas.
  void draw();

 private:
  void add(const std::string& data, const std::string& style);

  Canvas& canvas_;
  Box box_;
  Axis x_;
  Axis y_;
  std::string plots_;
};

}  // namespace ertbench
