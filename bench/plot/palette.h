#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// A colour of the screen, each part from 0 to 1.
struct Colour {
  double red = 0;
  double green = 0;
  double blue = 0;

  std::string hex() const;   ///< "#440154"
  int number() const;        ///< as gnuplot's `linecolor rgb variable` wants it
  double lightness() const;  ///< 0 black ... 1 white, as a grey printer would have it
  Colour towards_white(double fraction) const;
  Colour towards_black(double fraction) const;
  Colour for_text() const;  ///< as dark as a text on white has to be (contrast of 4.5 to 1)
};

/// "0x440154" as a colour.
constexpr Colour rgb(int number) {
  return {(number >> 16 & 0xff) / 255.0, (number >> 8 & 0xff) / 255.0, (number & 0xff) / 255.0};
}

/// Colours of everything except data.
namespace ink {
inline constexpr Colour black = rgb(0x000000);
inline constexpr Colour white = rgb(0xffffff);
inline constexpr Colour dark = rgb(0x303030);   ///< frames, limits
inline constexpr Colour note = rgb(0x404040);   ///< small print
inline constexpr Colour light = rgb(0x909090);  ///< lines from a text to its point
inline constexpr Colour alarm = rgb(0xa00000);  ///< what failed
}  // namespace ink

/// Viridis: perceptually uniform, rising in lightness, so that it reads in grey too.
Colour viridis(double fraction);

/// Palettes that map values to colours.
enum class Palette {
  sequential,  ///< viridis: from little to much
  diverging,   ///< blue below, red above and near white at the middle, which stands for zero
};

/// The palette as a command of gnuplot's.
std::string palette_command(Palette palette);

/// Hue `index` of a few that are distinguishable with any colour vision (Okabe and Ito).
Colour hue(std::size_t index);
inline constexpr std::size_t hues = 7;  ///< after so many they begin again

// How lines, marks, rectangles and texts look. Sizes are px, but those of marks, which are
// gnuplot's.

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

/// Filled shapes that are distinguishable in grey; one less is the same shape, hollow.
inline constexpr int shapes[] = {7, 5, 9, 11, 13, 15};
inline constexpr int cross = 2;
inline constexpr int circle = 6;

/// Filled shape `index`, modulo their number.
int filled(std::size_t index);
inline int hollow(std::size_t index) { return filled(index) - 1; }

struct BoxStyle {
  std::optional<Colour> fill = {};
  std::optional<LineStyle> border = {};
  bool front = false;  ///< above other rectangles and lines; texts are above all of them

  std::string text() const;  ///< as gnuplot has it
};

/// End of a text that is at its point.
enum class TextAlign { left, centre, right };

struct TextStyle {
  int size = 10;
  TextAlign align = TextAlign::centre;
  bool upright = false;  ///< read from below; then `left` is its lower end
  Colour colour = ink::black;
  bool boxed = false;  ///< on a white ground

  std::string text() const;  ///< as gnuplot has it
};

/// Width of a text in a sans-serif font of that size, px; slightly more than most need.
double text_width(const std::string& text, int size);
/// Number of characters of that size that fit into `width` px; at least one.
std::size_t characters_in(double width, int size);

/// Range of the colours of a figure. The ends are multiples of `step`.
struct ColourScale {
  double low = 0;
  double high = 0;
  double step = 0;     ///< between two ticks
  bool below = false;  ///< values under `low` exist and have its colour
  bool above = false;
};

/// One scale around zero for the true changes and all estimates, so that rises and falls of the
/// conductivity have the same colours everywhere. It spans all values that exceed the range of the
/// truth by at most half of its width on the side of the contacts, and a quarter on the other, so
/// that one image with large artefacts does not fade all others. At most about `ticks` steps.
/// Ignores values that are not finite.
ColourScale colour_scale(const Images& truth, const std::vector<Images>& estimates, int ticks);

}  // namespace ertbench
