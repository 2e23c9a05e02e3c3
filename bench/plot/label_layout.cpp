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
constexpr double beside = 3;  ///< a line as near to a text's edge would seem to be of that text, px

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

/// On which side of the line through a segment a point lies: the sign of their cross product.
double side_of(const Segment& line, double x, double y) {
  return (line.x2 - line.x1) * (y - line.y1) - (line.y2 - line.y1) * (x - line.x1);
}

/// The labels that have a place, with the lines to their points.
class PlacedLabels {
 public:
  bool free_for(const Box& box, const std::optional<Segment>& leader) const {
    const auto crossed = [&](const auto& other) { return leader && leader->crosses(other); };
    return std::none_of(boxes_.begin(), boxes_.end(), crossed) &&
           std::none_of(leaders_.begin(), leaders_.end(),
                        [&](const Segment& other) { return other.crosses(box) || crossed(other); });
  }
  void add(const Box& box, const std::optional<Segment>& leader) {
    boxes_.push_back(box);
    if (leader) leaders_.push_back(*leader);
  }

 private:
  std::vector<Box> boxes_;
  std::vector<Segment> leaders_;
};

}  // namespace

bool Segment::crosses(const Segment& other) const {
  return side_of(*this, other.x1, other.y1) * side_of(*this, other.x2, other.y2) < 0 &&
         side_of(other, x1, y1) * side_of(other, x2, y2) < 0;
}

bool Segment::crosses(const Box& box) const {
  const auto within = [&](double x, double y) {
    return x > box.left && x < box.right && y > box.top && y < box.bottom;
  };
  return within(x1, y1) || within(x2, y2) ||
         crosses(Segment{box.left, box.top, box.right, box.bottom}) ||
         crosses(Segment{box.left, box.bottom, box.right, box.top});
}

Segment leader_of(const PointLabel& label, const Box& place) {
  return {label.x, label.y, std::clamp(label.x, place.left, place.right),
          std::clamp(label.y, place.top, place.bottom)};
}

std::vector<std::optional<PlacedLabel>> place_labels(const std::vector<PointLabel>& labels,
                                                     int font_size, const Box& area,
                                                     std::vector<Box> taken,
                                                     const std::vector<Segment>& lines) {
  std::vector<std::optional<PlacedLabel>> out(labels.size());
  // Right, left, above, below, then what lies between.
  constexpr int order[directions] = {0, 8, 12, 4, 14, 2, 10, 6, 15, 1, 9, 7, 13, 11, 3, 5};
  PlacedLabels placed;
  // How much is wrong with a place, the worst first: its leader crosses another or a name, its
  // leader runs through or along what is taken, a line runs through the name.
  const auto faults = [&](const PointLabel& label, const Box& box,
                          const std::optional<Segment>& leader) {
    const auto met = [&](const Box& other) {  // but for what stands at the point itself
      return !other.contains(label.x, label.y) && leader->crosses(other.grown(beside));
    };
    const bool crosses = !placed.free_for(box, leader);
    const bool meets = leader && std::any_of(taken.begin(), taken.end(), met);
    const bool struck = std::any_of(lines.begin(), lines.end(),
                                    [&](const Segment& line) { return line.crosses(box); });
    return 4 * int{crosses} + 2 * int{meets} + int{struck};
  };
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const double width = text_width(labels[i].text, font_size) + 4;
    const double height = font_size + 3;
    std::optional<Segment> leader_of_best;
    int least = 8;
    for (double distance = nearest; distance <= farthest && least > 0; distance += 6) {
      const bool far = distance > nearest + 6;
      for (const int direction : order) {
        const Box box = box_at(labels[i], width, height, distance, direction);
        const bool free = std::none_of(taken.begin(), taken.end(),
                                       [&](const Box& other) { return box.overlaps(other); });
        if (!free || !inside(box, area)) continue;
        const auto leader = far ? std::optional(leader_of(labels[i], box)) : std::nullopt;
        const int wrong = faults(labels[i], box, leader);
        if (wrong >= least) continue;
        least = wrong;
        out[i] = PlacedLabel{box, far};
        leader_of_best = leader;
      }
    }
    if (!out[i]) continue;
    taken.push_back(out[i]->box);
    placed.add(out[i]->box, leader_of_best);
  }
  return out;
}

}  // namespace ertbench
