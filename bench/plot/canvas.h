#pragma once

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "bench/plot/gnuplot.h"
#include "bench/plot/svg_tooltips.h"

namespace ertbench {

/// gnuplot commands of a picture that is laid out by hand, in px from its top left corner.
class Canvas {
 public:
  Canvas(int width, int height);

  std::ostream& out() { return out_; }
  std::string text() const { return out_.str(); }

  /// The point as gnuplot writes it.
  std::string screen(double x, double y) const;
  /// Text at that point in a font of `size`; `options` of gnuplot's: "center rotate by 90".
  void label(const std::string& text, double x, double y, int size, const std::string& options);
  /// Lines of text under each other, centred; `y` is the middle of the first.
  void lines(const std::string& text, std::size_t characters, double x, double y, int size);
  void line(double x1, double y1, double x2, double y2, const std::string& style);
  void rectangle(double left, double top, double width, double height, const std::string& style);
  /// Where the axes of the next plot lie.
  void area(double left, double top, double width, double height);
  /// A plot of nothing, which draws the labels, lines and rectangles that have been set.
  void finish_marks();
  /// What the pointer shows over the rectangle, in the SVG; the last one where several overlap.
  void tooltip(double left, double top, double width, double height, std::string text);
  /// The same over a point drawn at (x, y).
  void tooltip_at(double x, double y, std::string text);

  /// draw_chart() of all this with its tooltips.
  void draw(const FileContents& inputs, const std::filesystem::path& stem) const;

 private:
  int width_;
  int height_;
  std::ostringstream out_;
  std::vector<Tooltip> tooltips_;
};

}  // namespace ertbench
