#include "forward/touch/characters.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Stroke = std::vector<Eigen::Vector2d>;

/// A stroke in the making: begins at a point and goes on along lines and arcs.
class Pen {
 public:
  Pen(double x, double y) : stroke_{{x, y}} {}

  Pen& to(double x, double y) {
    stroke_.emplace_back(x, y);
    return *this;
  }

  /// Along an ellipse around a centre from one direction to another, degrees counter-clockwise
  /// from x; a straight line leads to its beginning unless the pen stands there, within half a
  /// millimetre.
  Pen& arc(double x, double y, double radius_x, double radius_y, double from, double to) {
    constexpr double largest_step = 6;
    const int steps = static_cast<int>(std::ceil(std::abs(to - from) / largest_step));
    for (int i = 0; i <= steps; ++i) {
      const double angle = (from + (to - from) * i / steps) * std::numbers::pi / 180;
      const Eigen::Vector2d point(x + radius_x * std::cos(angle), y + radius_y * std::sin(angle));
      if ((point - stroke_.back()).norm() > 0.5) stroke_.push_back(point);
    }
    return *this;
  }

  operator Stroke() const { return stroke_; }  // implicit: a list of pens is a list of strokes

 private:
  Stroke stroke_;
};

std::vector<Character> drawn_digits() {
  return {
      {'0', {Pen(0, 60).arc(0, 0, 36, 60, 90, 450), Pen(-24, -40).to(24, 40)}},
      {'1', {Pen(-28, 30).to(5, 60).to(5, -60)}},
      {'2', {Pen(-38, 26).arc(0, 26, 38, 34, 180, -35).to(-38, -60).to(40, -60)}},
      {'3', {Pen(-32, 45).arc(0, 30, 36, 30, 150, -90).arc(0, -30, 40, 30, 90, -150)}},
      {'4', {Pen(20, -60).to(20, 60).to(-45, -25).to(45, -25)}},
      {'5', {Pen(-28, 60).to(-34, 4).arc(-2, -20, 40, 40, 143, -140), Pen(-28, 60).to(36, 60)}},
      {'6', {Pen(28, 58).arc(28, -22, 66, 80, 90, 180).arc(0, -22, 38, 38, 180, 540)}},
      {'7', {Pen(-40, 60).to(40, 60).to(-12, -60)}},
      {'8', {Pen(0, 4).arc(0, 32, 30, 28, -90, 270).arc(0, -28, 40, 32, 90, -270)}},
      {'9', {Pen(38, 22).arc(0, 22, 38, 38, 0, 360).arc(-28, 22, 66, 82, 0, -90)}},
  };
}

std::vector<Character> drawn_letters() {
  return {
      {'A', {Pen(-50, -60).to(0, 60).to(50, -60), Pen(-33, -20).to(33, -20)}},
      {'B',
       {Pen(-36, -60)
            .to(-36, 60)
            .to(4, 60)
            .arc(4, 32, 28, 28, 90, -90)
            .to(-36, 4)
            .to(4, 4)
            .arc(4, -28, 34, 32, 90, -90)
            .to(-36, -60)}},
      {'C', {Pen(42, 38).arc(0, 0, 54, 60, 40, 320)}},
      {'D', {Pen(-40, -60).to(-40, 60).to(-10, 60).arc(-10, 0, 52, 60, 90, -90).to(-40, -60)}},
      {'E', {Pen(38, 60).to(-36, 60).to(-36, -60).to(38, -60), Pen(-36, 0).to(26, 0)}},
      {'F', {Pen(38, 60).to(-36, 60).to(-36, -60), Pen(-36, 2).to(26, 2)}},
      {'G', {Pen(42, 38).arc(0, 0, 54, 60, 40, 350).to(53, -6).to(12, -6)}},
      {'H', {Pen(-42, 60).to(-42, -60), Pen(42, 60).to(42, -60), Pen(-42, 0).to(42, 0)}},
      {'I', {Pen(-28, 60).to(28, 60), Pen(0, 60).to(0, -60), Pen(-28, -60).to(28, -60)}},
      {'J', {Pen(28, 60).to(28, -24).arc(-6, -24, 34, 36, 0, -170)}},
      {'K', {Pen(-38, 60).to(-38, -60), Pen(40, 60).to(-38, -8), Pen(-10, 16).to(42, -60)}},
      {'L', {Pen(-34, 60).to(-34, -60).to(40, -60)}},
      {'M', {Pen(-52, -60).to(-46, 60).to(0, -20).to(46, 60).to(52, -60)}},
      {'N', {Pen(-42, -60).to(-42, 60).to(42, -60).to(42, 60)}},
      {'O', {Pen(0, 60).arc(0, 0, 60, 60, 90, 450)}},
      {'P', {Pen(-36, -60).to(-36, 60).to(2, 60).arc(2, 28, 36, 32, 90, -90).to(-36, -4)}},
      {'Q', {Pen(0, 60).arc(0, 4, 56, 56, 90, 450), Pen(14, -18).to(54, -60)}},
      {'R',
       {Pen(-36, -60)
            .to(-36, 60)
            .to(2, 60)
            .arc(2, 29, 34, 31, 90, -90)
            .to(-36, -2)
            .to(-4, -2)
            .to(42, -60)}},
      {'S', {Pen(32, 44).arc(0, 30, 36, 30, 30, 270).arc(0, -30, 40, 30, 90, -150)}},
      {'T', {Pen(-48, 60).to(48, 60), Pen(0, 60).to(0, -60)}},
      {'U', {Pen(-42, 60).to(-42, -18).arc(0, -18, 42, 42, 180, 360).to(42, 60)}},
      {'V', {Pen(-46, 60).to(0, -60).to(46, 60)}},
      {'W', {Pen(-58, 60).to(-30, -60).to(0, 30).to(30, -60).to(58, 60)}},
      {'X', {Pen(-44, 60).to(44, -60), Pen(44, 60).to(-44, -60)}},
      {'Y', {Pen(-44, 60).to(0, 2).to(44, 60), Pen(0, 2).to(0, -60)}},
      {'Z', {Pen(-44, 60).to(44, 60).to(-44, -60).to(44, -60)}},
  };
}

std::vector<Character> all_characters() {
  std::vector<Character> all = drawn_digits();
  for (Character& letter : drawn_letters()) all.push_back(std::move(letter));
  return all;
}

}  // namespace

const std::vector<Character>& characters() {
  static const std::vector<Character> all = all_characters();
  return all;
}

const Character& character(char symbol) {
  std::string known;
  for (const Character& one : characters()) {
    if (one.symbol == symbol) return one;
    known += one.symbol;
  }
  throw InputError("no character \"" + printable(std::string(1, symbol)) + "\"; there are " +
                   known);
}

}  // namespace ertbench
