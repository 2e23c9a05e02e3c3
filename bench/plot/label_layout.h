#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"

namespace ertbench {

/// A text to be placed near its point.
struct PointLabel {
  std::string text;
  double x = 0;  ///< of the point, px
  double y = 0;
  Colour colour = ink::black;
};

struct PlacedLabel {
  Box box;
  bool leader = false;  ///< far enough from the point to need a line to it
};

/// A straight line between two points, px.
struct Segment {
  double x1, y1;
  double x2, y2;

  bool crosses(const Segment& other) const;
  bool crosses(const Box& box) const;  ///< or lies within
};

/// Line from the point to the nearest point of its label.
Segment leader_of(const PointLabel& label, const Box& place);

/// Places each label as near to its point as possible, within `area` and clear of `taken` and of
/// other labels; px. Avoids leader lines that cross each other or a label. A px of a leader line
/// over `taken` costs as much as 4 px of distance, and one of `lines` through a text as much as 40
/// px. A label without room has no value, the last ones first. Deterministic.
std::vector<std::optional<PlacedLabel>> place_labels(const std::vector<PointLabel>& labels,
                                                     int font_size, const Box& area,
                                                     const std::vector<Box>& taken,
                                                     const std::vector<Segment>& lines = {});

}  // namespace ertbench
