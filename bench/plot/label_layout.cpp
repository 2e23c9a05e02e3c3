#include "bench/plot/label_layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/plot/style.h"

namespace ertbench {
namespace {

constexpr double nearest = 8;  ///< from the point to the label's edge, px
constexpr double farthest = 110;
constexpr double step = 6;
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

/// What is wrong with a place, in px by which it may be farther away for that not to be so: enough
/// for a leader that crosses another or a name to be the last that is taken.
constexpr double crossing = 1000;
constexpr double meeting = 60;   ///< a leader runs through or along what is taken
constexpr double striking = 40;  ///< a line runs through the name
constexpr int most_sweeps = 10;

/// A place for a label, of which there are many.
struct Candidate {
  PlacedLabel label;
  Segment leader;   ///< means something where the label has one
  double cost = 0;  ///< without what other labels do to it
};

bool in_conflict(const Candidate& a, const Candidate& b) {
  const bool through = (a.label.leader && a.leader.crosses(b.label.box)) ||
                       (b.label.leader && b.leader.crosses(a.label.box));
  return through || (a.label.leader && b.label.leader && a.leader.crosses(b.leader));
}

/// The places of a label that are clear of `taken`, the nearest first.
std::vector<Candidate> candidates_of(const PointLabel& label, int font_size, const Box& area,
                                     const std::vector<Box>& taken,
                                     const std::vector<Segment>& lines) {
  // Right, left, above, below, then what lies between.
  constexpr int order[directions] = {0, 8, 12, 4, 14, 2, 10, 6, 15, 1, 9, 7, 13, 11, 3, 5};
  const double width = text_width(label.text, font_size) + 4;
  const double height = font_size + 3;
  std::vector<Candidate> out;
  for (double distance = nearest; distance <= farthest; distance += step) {
    for (const int direction : order) {
      const Box box = box_at(label, width, height, distance, direction);
      const bool free = std::none_of(taken.begin(), taken.end(),
                                     [&](const Box& other) { return box.overlaps(other); });
      if (!free || !inside(box, area)) continue;
      Candidate found{{box, distance > nearest + step}, leader_of(label, box), distance};
      const auto met = [&](const Box& other) {  // but for what stands at the point itself
        return !other.contains(label.x, label.y) && found.leader.crosses(other.grown(beside));
      };
      const auto strikes = [&](const Segment& line) { return line.crosses(box); };
      if (found.label.leader && std::any_of(taken.begin(), taken.end(), met)) found.cost += meeting;
      if (std::any_of(lines.begin(), lines.end(), strikes)) found.cost += striking;
      out.push_back(found);
    }
  }
  return out;
}

/// Gives every label the cheapest of its places, as the others stand.
class Layout {
 public:
  explicit Layout(std::vector<std::vector<Candidate>> candidates)
      : candidates_(std::move(candidates)), chosen_(candidates_.size()) {}

  /// Whether the label has found another place.
  bool place(std::size_t label) {
    std::optional<std::size_t> best;
    double least = INFINITY;
    for (std::size_t c = 0; c < candidates_[label].size(); ++c) {
      const double cost = cost_of(label, candidates_[label][c], least);
      if (cost >= least) continue;
      least = cost;
      best = c;
    }
    if (best == chosen_[label]) return false;
    chosen_[label] = best;
    return true;
  }

  std::optional<PlacedLabel> operator[](std::size_t label) const {
    const Candidate* found = chosen(label);
    return found ? std::optional(found->label) : std::nullopt;
  }

 private:
  const Candidate* chosen(std::size_t label) const {
    return chosen_[label] ? &candidates_[label][*chosen_[label]] : nullptr;
  }

  /// Infinite on another label's text; no longer right once it is at least `enough`.
  double cost_of(std::size_t label, const Candidate& candidate, double enough) const {
    double cost = candidate.cost;
    for (std::size_t i = 0; i < candidates_.size() && cost < enough; ++i) {
      const Candidate* other = i == label ? nullptr : chosen(i);
      if (!other) continue;
      if (candidate.label.box.overlaps(other->label.box)) return INFINITY;
      if (in_conflict(candidate, *other)) cost += crossing;
    }
    return cost;
  }

  std::vector<std::vector<Candidate>> candidates_;
  std::vector<std::optional<std::size_t>> chosen_;
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
                                                     const std::vector<Box>& taken,
                                                     const std::vector<Segment>& lines) {
  std::vector<std::vector<Candidate>> candidates;
  candidates.reserve(labels.size());
  for (const PointLabel& label : labels) {
    candidates.push_back(candidates_of(label, font_size, area, taken, lines));
  }
  // The first ones choose first, and each again once the others stand, until none finds a better
  // place. Places of equal cost could be changed for ever: hence a most of sweeps.
  Layout layout(std::move(candidates));
  bool moved = true;
  for (int sweep = 0; sweep < most_sweeps && moved; ++sweep) {
    moved = false;
    for (std::size_t i = 0; i < labels.size(); ++i) moved |= layout.place(i);
  }
  std::vector<std::optional<PlacedLabel>> out;
  for (std::size_t i = 0; i < labels.size(); ++i) out.push_back(layout[i]);
  return out;
}

}  // namespace ertbench
