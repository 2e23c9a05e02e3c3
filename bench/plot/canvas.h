#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/plot/box.h"
#include "bench/plot/gnuplot.h"
#include "bench/plot/style.h"
#include "bench/plot/svg_tooltips.h"
#include "core/text_stream.h"

namespace ertbench {

/// A picture, laid out in px from its top left corner. Panels, images and colour bars put their
/// plots on it; texts, lines, rectangles and marks are drawn above all plots.
class Canvas {
 public:
  Canvas(double width, double height);

  int width() const { return width_; }
  int height() const { return height_; }

  void text(const std::string& text, double x, double y, const TextStyle& style = {});
  /// Lines of at most `characters` under each other; `y` is the middle of the first.
  void lines(const std::string& text, std::size_t characters, double x, double y,
             const TextStyle& style = {});
  /// The heading of the picture, cut to its width.
  void title(const std::string& text);
  /// "(a)", "(b)", ... at the left of a row of panels.
  void letter(int index, double y);
  void line(double x1, double y1, double x2, double y2, const LineStyle& style);
  void rectangle(const Box& box, const BoxStyle& style);
  void mark(double x, double y, const MarkStyle& style);

  /// What the pointer shows over the box, in the SVG; the last one where several overlap.
  void tooltip(const Box& box, std::string text);
  /// The same over a point drawn at (x, y).
  void tooltip_at(double x, double y, std::string text);

  // For what plots with gnuplot's own commands:
  std::ostream& plots() { return plots_; }
  /// Where the axes of the next plot lie.
  void area(const Box& box);
  /// Keeps data for a plot and returns the name of their file, in quotes.
  std::string data(const std::string& text);

  /// Draws `stem`.svg and `stem`.png. Throws InputError where gnuplot is missing or a file cannot
  /// be written.
  void draw(const std::filesystem::path& stem) const;

 private:
  std::string screen(double x, double y) const;

  int width_;
  int height_;
  TextStream plots_;
  TextStream marks_;
  FileContents files_;
  std::vector<Tooltip> tooltips_;
};

}  // namespace ertbench
