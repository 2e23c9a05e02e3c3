#pragma once

#include <Eigen/Core>
#include <vector>

namespace ertbench {

/// How a character is drawn with one finger.
struct Character {
  char symbol;
  /// In the order of drawing, each a polyline of points in mm, x to the right and y up, in the box
  /// [-60, 60] x [-60, 60]; between two strokes the finger is lifted.
  std::vector<std::vector<Eigen::Vector2d>> strokes;
};

/// The digits 0-9, then the letters A-Z, no two of one path: the zero is narrow and has a slash,
/// the O is round, the I has serifs.
const std::vector<Character>& characters();

/// One of characters(). Throws InputError naming those there are.
const Character& character(char symbol);

}  // namespace ertbench
