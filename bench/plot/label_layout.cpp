#include "bench/plot/label_layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/plot/style.h"

namespace ertbench {
namespace {

constexpr double nearest = 8;  ///< from the point to the label's edge, px
constexpr double farthest = 110;
constexpr int directions = 16;

/// The box whose side or corner faces the point from that direction (0 right, then downwards).
Box box_at(const PointLabel& label, double width, double height, double distance, int direction) {
  const double angle = 2 * std::numbers::pi * direction / directions;
  const double x = label.x + distance * std::cos(angle);
  const double y = label.y + distance * std::sin(angle);
  const double left = x - width * (1 - std::cos(angle)) / 2;
  const double top = y - height * (1 - std::sin(angle)) / 2;
  return {left, top, left + width, top + height};
}

bool inside(const Box& box, const Box& area) {
  return box.left >= area.left && box.right <= area.right && box.top >= area.top &&
         box.bottom <= area.bottom;
}

}  // namespace

std::vector<std::optional<PlacedLabel>> place_labels(const std::vector<PointLabel>& labels,
                                                     int font_size, const Box& area,
                                                     std::vector<Box> taken) {
  std::vector<std::optional<PlacedLabel>> out(labels.size());
  // Right, left, above, below, then what lies between.
  constexpr int order[directions] = {0, 8, 12, 4, 14, 2, 10, 6, 15, 1, 9, 7, 13, 11, 3, 5};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const double width = text_width(labels[i].text, font_size) + 4;
    const double height = font_size + 3;
    for (double distance = nearest; distance <= farthest && !out[i]; distance += 6) {
      for (const int direction : order) {
        const Box box = box_at(labels[i], width, height, distance, direction);
        if (!inside(box, area)) continue;
        const bool free = std::none_of(taken.begin(), taken.end(),
                                       [&](const Box& other) { return box.overlaps(other); });
        if (!free) continue;
        out[i] = PlacedLabel{box, distance > nearest + 6};
        taken.push_back(box);
        break;
      }
    }
  }
  return out;
}

}  // namespace ertbench
