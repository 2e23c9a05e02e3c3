#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"

namespace ertbench {

/// A text that is to stand near its point.
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

/// From the point to the nearest place of its label.
Segment leader_of(const PointLabel& label, const Box& place);

/// Finds a place for each label: as near to its point as can be, within `area` and clear of `taken`
/// and of the other labels; px. Its line to the point crosses neither another one nor a label where
/// the labels can be laid out so; and rather than have that line run through or along what is
/// `taken`, 4 px for each px of it, or one of `lines` through its text, 40 px for each, a label
/// takes a place farther off. A label for which there is no room has no value, the last ones first.
/// The same labels always have the same places.
std::vector<std::optional<PlacedLabel>> place_labels(const std::vector<PointLabel>& labels,
                                                     int font_size, const Box& area,
                                                     const std::vector<Box>& taken,
                                                     const std::vector<Segment>& lines = {});

}  // namespace ertbench
