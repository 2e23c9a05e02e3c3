#pragma once

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

}  // namespace ertbench
