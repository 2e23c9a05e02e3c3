#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"

namespace ertbench {

/// A text to be placed near its point.
struct PointLabel {
  std::string text;
  double x = 0;  ///< of the point, px
  double y = 0;
  Colour colour = ink::black;
};

struct PlacedLabel {
  Box box;
  bool leader = false;  ///< far enough from the point to need a line to it
};

/// A straight line between two points, px.
struct Segment {
  double x1, y1;
  double x2, y2;

  bool crosses(const Segment& other) const;
  bool crosses(const Box& box) const;  ///< or lies within
};

/// Line from the point to the nearest point of its label.
Segment leader_of(const PointLabel& label, const Box& place);

/// Places each label as near to its point as possible, within `area` and clear of `taken` and of
/// other labels; px. Avoids leader lines that cross each other or a label. A px of a leader line
/// over `taken` costs as much as 4 px of distance, and one of `lines` through a text as much as 40
/// px. A label without room has no value, the last ones first. Deterministic.
std::vector<std::optional<PlacedLabel>> place_labels(const std::vector<PointLabel>& labels,
                                                     int font_size, const Box& area,
                                                     const std::vector<Box>& taken,
                                                     const std::vector<Segment>& lines = {});

/// Range of values; empty before the first value.
struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

/// The smallest step, 1, 2 or 5 times a power of ten, that divides `span` into at most `ticks`
/// steps.
double round_step(double span, int ticks);

/// Multiples of a round step within the span, at most about `ticks`; none if the span is too narrow
/// for different numbers.
std::vector<double> even_ticks(const Span& span, int ticks);

/// Ticks of a logarithmic axis: even steps over a narrow range, 1, 2, 5, 10, ... over a few
/// decades, powers of ten over many. The span must be positive.
std::vector<double> log_ticks(const Span& span);

/// A tick of an axis with its text; an empty text draws only the grid line.
struct Tick {
  double value = 0;
  std::string text;
};

/// Ticks of a logarithmic axis in µs, one each decade: "10 µs", "1 ms".
std::vector<Tick> time_ticks();
/// As above for frames per second: "100", "1 k".
std::vector<Tick> rate_ticks();

/// Scale along one side of a panel or of a colour bar.
struct Axis {
  double low = 0;
  double high = 1;
  bool logarithmic = false;
  std::vector<Tick> ticks = {};
  std::string title = {};
  bool slanted = false;  ///< the ticks' texts stand at 45 degrees
  bool grid = true;      ///< a light line at each tick

  /// With even ticks.
  static Axis even(const Span& span, std::string title = {});
  /// With logarithmic ticks; the span must be positive.
  static Axis logarithms(const Span& span, std::string title = {});

  /// Position of a value: 0 at `low` to 1 at `high`.
  double share(double value) const;
  double capped(double value) const { return std::clamp(value, low, high); }
  /// Labels the upper end "≥ 10", where larger values are drawn.
  void cap();
};

/// Names below the slots of a panel: horizontal and wrapped if their words fit the slots, else all
/// vertical.
class CategoryNames {
 public:
  /// `slot`: width of a slot, px.
  CategoryNames(std::vector<std::string> names, double slot);

  bool upright() const { return upright_; }
  double height() const;  ///< px that they need below the panel
  /// `left` and `bottom` are the panel's, px.
  void draw(Canvas& canvas, double left, double bottom) const;

 private:
  std::vector<std::string> names_;
  double slot_;
  bool upright_;
};

/// Width of the widest unbreakable piece of a text, px.
double widest_word(const std::string& text, int size);

/// Legend entry of a line, a mark or a colour; any of them may be absent.
struct LegendEntry {
  std::string text;
  std::optional<LineStyle> line = {};
  std::optional<MarkStyle> mark = {};
  std::optional<Colour> fill = {};
};

/// Legend entries in as many lines as they need.
class Legend {
 public:
  static constexpr double line_height = 18;

  /// Between two edges of a picture, px; with `columns`, in columns of equal width, of
  /// which a text that is too long for one takes several.
  Legend(double left, double right, std::optional<int> columns = {});

  void add(LegendEntry entry);
  /// Starts a new line of entries.
  void new_line() { broken_ = true; }

  double height() const { return entries_.empty() ? 0 : line_height * (line_ + 1); }
  /// `top` is the middle of the first line, px.
  void draw(Canvas& canvas, double top) const;

 private:
  struct Place {
    LegendEntry entry;
    double left;  ///< px
    int line;
  };

  double left_;
  double right_;
  std::optional<int> columns_;
  std::vector<Place> entries_;
  double next_ = 0;  ///< px from the left edge
  int line_ = 0;
  bool broken_ = false;
};

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

/// A pair of axes on a canvas with plots in the order of the calls. Plots without points are left
/// out.
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
  /// A line from side to side at a value of the vertical axis.
  void level(double value, const LineStyle& style);
  /// A band from side to side between two values of the vertical axis.
  void band(double low, double high, const Colour& colour);
  /// A band between the ends of the whiskers, which are in the order of the axis across.
  void band(const std::vector<Whisker>& edges, const Colour& colour);
  void whiskers(const std::vector<Whisker>& whiskers, const LineStyle& style);
  void whiskers_across(const std::vector<Whisker>& whiskers, const LineStyle& style);
  /// `width` in units of the axis across.
  void bars(const std::vector<Bar>& bars, double width);

  /// Texts near their points (px), clear of each other and of `taken`, with a leader line to
  /// distant points. Avoids `lines` (px); texts without room are left out.
  void labels(const std::vector<PointLabel>& labels, const std::vector<Box>& taken,
              const std::vector<Segment>& lines = {});

  /// Tooltip over a point.
  void tooltip(double x_value, double y_value, std::string text);

  /// Puts the panel on the canvas.
  void draw();

 private:
  void add(const std::vector<std::vector<double>>& rows, const std::string& style);

  Canvas& canvas_;
  Box box_;
  Axis x_;
  Axis y_;
  std::string plots_;
};

}  // namespace ertbench
