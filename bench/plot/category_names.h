#pragma once

#include <string>
#include <vector>

#include "bench/plot/canvas.h"

namespace ertbench {

/// Names below the slots of a panel: level, in lines, where their words fit the slots; else all of
/// them upright.
class CategoryNames {
 public:
  /// `slot` is the width of each, px.
  CategoryNames(std::vector<std::string> names, double slot, int size = 9);

  bool upright() const { return upright_; }
  double height() const;  ///< px that they need below the panel
  /// `left` and `bottom` are the panel's, px.
  void draw(Canvas& canvas, double left, double bottom) const;

 private:
  std::vector<std::string> names_;
  double slot_;
  int size_;
  bool upright_;
};

/// The width of the widest piece of a text that is not broken between lines, px.
double widest_word(const std::string& text, int size);

}  // namespace ertbench
