#pragma once

#include <string>

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

/// What is drawn beside the data.
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

/// How colours stand for values.
enum class Palette {
  sequential,  ///< viridis: from little to much
  diverging,   ///< blue below, red above and near white at the middle, which stands for zero
};

/// The palette as a command of gnuplot's.
std::string palette_command(Palette palette);

/// `index` of a few hues that are told apart with any kind of colour vision (Okabe and Ito).
Colour hue(std::size_t index);
inline constexpr std::size_t hues = 7;  ///< after so many they begin again

}  // namespace ertbench
