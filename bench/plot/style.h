#pragma once

#include <optional>
#include <string>

#include "bench/plot/palette.h"

/// How lines, marks, rectangles and texts look. Sizes are px, but those of marks, which are
/// gnuplot's.
namespace ertbench {

struct LineStyle {
  Colour colour = ink::dark;
  double width = 1;
  int dash = 1;  ///< 1 whole, 2 dashed, 3 dotted, 4 and 5 dashed with dots

  std::string text() const;  ///< as gnuplot has it
};

struct MarkStyle {
  int shape = 7;  ///< one of `shapes`, or `cross`
  Colour colour = ink::dark;
  double size = 0.9;
  double width = 1.4;

  std::string text() const;  ///< as gnuplot has it
};

/// Filled shapes that are told apart in grey; one less is the same shape, hollow.
inline constexpr int shapes[] = {7, 5, 9, 11, 13, 15};
inline constexpr int cross = 2;
inline constexpr int circle = 6;

/// `index` of the filled shapes, begun again after the last.
int filled(std::size_t index);
inline int hollow(std::size_t index) { return filled(index) - 1; }

struct BoxStyle {
  std::optional<Colour> fill = {};
  std::optional<LineStyle> border = {};
  bool front = false;  ///< above other rectangles and lines; texts are above all of them

  std::string text() const;  ///< as gnuplot has it
};

/// Which end of a text is at its point.
enum class TextAlign { left, centre, right };

struct TextStyle {
  int size = 10;
  TextAlign align = TextAlign::centre;
  bool upright = false;  ///< read from below; then `left` is its lower end
  Colour colour = ink::black;
  bool boxed = false;  ///< on a white ground

  std::string text() const;  ///< as gnuplot has it
};

/// Width of a text in a sans-serif font of that size, px; a little more than most take.
double text_width(const std::string& text, int size);
/// How many characters of that size fit into `width` px; at least one.
std::size_t characters_in(double width, int size);

}  // namespace ertbench
