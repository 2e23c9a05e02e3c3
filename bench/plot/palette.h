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
};

/// Viridis: perceptually uniform, rising in lightness, so that it reads in grey too.
Colour viridis(double fraction);

/// Viridis as a command of gnuplot's.
std::string palette_command();

/// `index` of a few hues that are told apart with any kind of colour vision (Okabe and Ito).
Colour hue(std::size_t index);

}  // namespace ertbench
