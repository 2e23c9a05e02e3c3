#pragma once

#include <sstream>
#include <string>

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

 private:
  int width_;
  int height_;
  std::ostringstream out_;
};

}  // namespace ertbench
