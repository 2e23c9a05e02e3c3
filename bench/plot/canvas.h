#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {

/// A rectangle of a chart, px from its top left corner.
struct Box {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;

  static Box sized(double left, double top, double width, double height) {
    return {left, top, left + width, top + height};
  }
  /// The smallest box around a point that reaches `reach` px to each side.
  static Box around(double x, double y, double reach) {
    return {x - reach, y - reach, x + reach, y + reach};
  }

  Box grown(double by) const { return {left - by, top - by, right + by, bottom + by}; }

  double width() const { return right - left; }
  double height() const { return bottom - top; }
  double middle() const { return (left + right) / 2; }                  ///< across
  double centre() const { return (top + bottom) / 2; }                  ///< down
  double across(double share) const { return left + share * width(); }  ///< 0 left ... 1 right
  double up(double share) const { return bottom - share * height(); }   ///< 0 bottom ... 1 top

  bool contains(double x, double y) const {
    return x >= left && x <= right && y >= top && y <= bottom;
  }
  bool overlaps(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

/// An invisible rectangle of a chart with a tooltip `text`, which may have several lines.
struct Tooltip {
  Box box;
  std::string text;
};

/// Adds tooltips on top of an SVG picture, the last one uppermost, as `<title>` elements, which
/// need no script. Throws std::invalid_argument if `svg` has no end. Charts use Canvas::tooltip()
/// and Canvas::draw() instead.
std::string with_tooltips(const std::string& svg, const std::vector<Tooltip>& tooltips);

/// Files by name: texts and pictures alike.
using FileContents = std::map<std::string, std::string>;

/// Runs a gnuplot script in a temporary folder with the files `inputs`, and returns the files
/// `outputs`. Ignores the user's gnuplot settings. Throws InputError if gnuplot is not installed,
/// and std::runtime_error with gnuplot's message if it fails.
FileContents run_gnuplot(const std::string& script, const FileContents& inputs,
                         const std::vector<std::string>& outputs);

/// `text` as a quoted string of gnuplot without special characters.
std::string gnuplot_string(const std::string& text);

/// A picture in px from its top left corner. Panels, images and colour bars add plots; texts,
/// lines, rectangles and marks are drawn above all plots.
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

  /// Tooltip over a box in the SVG; the last one wins if several overlap.
  void tooltip(const Box& box, std::string text);
  /// Tooltip over a point drawn at (x, y).
  void tooltip_at(double x, double y, std::string text);

  // For plots with gnuplot commands:
  std::ostream& plots() { return plots_; }
  /// Sets the position of the next plot's axes.
  void area(const Box& box);
  /// Keeps data for a plot and returns the name of their file, in quotes.
  std::string data(const std::string& text);

  /// Draws `stem`.svg and `stem`.png (`stem` with its folder, without an ending), replacing files
  /// atomically. The PNG is three times as large, twice above 800 000 px, and has no tooltips.
  /// Throws InputError if gnuplot is missing or a file cannot be written.
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

/// Draws one figure, `stem`.svg and `stem`.png. If `draw` throws, logs a warning, writes the reason
/// to `stem`.svg and no `stem`.png, so that a failed figure does not end the report. Returns true
/// if it was drawn.
bool draw_or_say(const std::filesystem::path& stem, const std::function<void()>& draw);

}  // namespace ertbench
