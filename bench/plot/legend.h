#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/plot/canvas.h"

namespace ertbench {

/// What a line, a mark or a colour stands for; any of them may be absent.
struct LegendEntry {
  std::string text;
  std::optional<LineStyle> line = {};
  std::optional<MarkStyle> mark = {};
  std::optional<Colour> fill = {};
};

/// Entries beside each other, in as many lines as they need.
class Legend {
 public:
  static constexpr double line_height = 18;

  /// Between two edges of a picture, px; with `columns`, in columns of equal width, of
  /// which a text that is too long for one takes several.
  Legend(double left, double right, std::optional<int> columns = {});

  void add(LegendEntry entry);
  /// What is added next begins a line.
  void new_line() { broken_ = true; }

  double height() const { return entries_.empty() ? 0 : line_height * (line_ + 1); }
  /// `top` is the middle of the first line, px.
  void draw(Canvas& canvas, double top) const;

 private:
  struct Place {
    LegendEntry entry;
    double left;  ///< px
    int line;
  };

  double left_;
  double right_;
  std::optional<int> columns_;
  std::vector<Place> entries_;
  double next_ = 0;  ///< px from the left edge
  int line_ = 0;
  bool broken_ = false;
};

}  // namespace ertbench
