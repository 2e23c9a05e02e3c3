#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/plot/panel.h"
#include "core/random.h"

namespace ertbench {
namespace {

constexpr double nearest = 8;  ///< from the point to the label's edge, px
constexpr double step = 6;
constexpr int distances = 18;  ///< to 110 px
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

/// On which side of the line through a segment a point lies: the sign of their cross product.
double side_of(const Segment& line, double x, double y) {
  return (line.x2 - line.x1) * (y - line.y1) - (line.y2 - line.y1) * (x - line.x1);
}

// Costs of a position's flaws, as the px of additional distance that each is worth.
constexpr double along = 4;         ///< of a leader, each px that runs through what is taken
constexpr double striking = 40;     ///< each line that runs through the name
constexpr double crossing = 1000;   ///< a leader crosses another or a name
constexpr double absent = 2000;     ///< no place at all; up to twice that for the first labels
constexpr double covering = 10000;  ///< a name on a name, which no layout is left with

constexpr int most_sweeps = 10;

// The annealing: from moves by tens of px to none that is worse.
constexpr int moves_per_label = 3000;
constexpr double hottest = 150;
constexpr double coldest = 2;

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

/// How much of a segment lies within a box, px (Liang and Barsky 1984).
double length_within(const Segment& line, const Box& box) {
  const double dx = line.x2 - line.x1;
  const double dy = line.y2 - line.y1;
  double from = 0;
  double to = 1;
  const auto clip = [&](double start, double by, double low, double high) {
    if (by == 0) {
      if (start < low || start > high) to = from;
      return;
    }
    const double first = (low - start) / by;
    const double second = (high - start) / by;
    from = std::max(from, std::min(first, second));
    to = std::min(to, std::max(first, second));
  };
  clip(line.x1, dx, box.left, box.right);
  clip(line.y1, dy, box.top, box.bottom);
  return std::max(to - from, 0.0) * std::hypot(dx, dy);
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
  for (int i = 0; i < distances; ++i) {
    const double distance = nearest + i * step;
    for (const int direction : order) {
      const Box box = box_at(label, width, height, distance, direction);
      const bool free =
          std::ranges::none_of(taken, [&](const Box& other) { return box.overlaps(other); });
      if (!free || !area.contains(box.left, box.top) || !area.contains(box.right, box.bottom)) {
        continue;
      }
      Candidate found{{box, distance > nearest + step}, leader_of(label, box), distance};
      if (found.label.leader) {
        for (const Box& other : taken) {
          if (other.contains(label.x, label.y)) continue;  // it stands at the point itself
          found.cost += along * length_within(found.leader, other.grown(beside));
        }
      }
      const auto strikes = [&](const Segment& line) { return line.crosses(box); };
      found.cost += striking * static_cast<double>(std::ranges::count_if(lines, strikes));
      out.push_back(found);
    }
  }
  return out;
}

/// A place for each label, or none, so that what is wrong with all of them together is little.
class Layout {
 public:
  explicit Layout(std::vector<std::vector<Candidate>> candidates)
      : candidates_(std::move(candidates)), chosen_(candidates_.size()) {}

  /// Gives each label in turn the best of its places, as the others stand, until none finds a
  /// better one. Places of equal cost could be changed for ever: hence a most of sweeps.
  void settle() {
    bool moved = true;
    for (int sweep = 0; sweep < most_sweeps && moved; ++sweep) {
      moved = false;
      for (std::size_t i = 0; i < candidates_.size(); ++i) moved |= take_best(i);
    }
  }

  /// Moves one label at a time to a place drawn at random, also to a worse one while it is hot
  /// (simulated annealing; for labels Christensen, Marks and Shieber 1995): where each stands best
  /// as the others stand, two that gave way together may stand better.
  void anneal() {
    const int labels = static_cast<int>(candidates_.size());
    RandomStream random(0, key_of("places of labels"), 0, Purpose::scene);
    const int moves = moves_per_label * labels;
    for (int move = 0; move < moves; ++move) {
      const double heat = hottest * std::pow(coldest / hottest, 1.0 * move / moves);
      const auto label = static_cast<std::size_t>(random.integer(0, labels - 1));
      const int places = static_cast<int>(candidates_[label].size());
      const int drawn = random.integer(0, places);  // the last one: none
      Choice place;
      if (drawn < places) place = static_cast<std::size_t>(drawn);
      const double gain = cost_of(label, chosen_[label]) - cost_of(label, place);
      if (random.uniform() < std::exp(gain / heat)) chosen_[label] = place;
    }
  }

  double cost() const {
    double sum = 0;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      sum += own_cost(i, chosen_[i]);
      for (std::size_t j = 0; j < i; ++j) {
        sum += pair_cost(chosen(i, chosen_[i]), chosen(j, chosen_[j]));
      }
    }
    return sum;
  }

  std::optional<PlacedLabel> operator[](std::size_t label) const {
    const Candidate* found = chosen(label, chosen_[label]);
    return found ? std::optional(found->label) : std::nullopt;
  }

 private:
  using Choice = std::optional<std::size_t>;

  const Candidate* chosen(std::size_t label, const Choice& choice) const {
    return choice ? &candidates_[label][*choice] : nullptr;
  }

  double own_cost(std::size_t label, const Choice& choice) const {
    const auto later = static_cast<double>(label) / static_cast<double>(candidates_.size());
    return choice ? candidates_[label][*choice].cost : absent * (2 - later);
  }

  static double pair_cost(const Candidate* a, const Candidate* b) {
    if (!a || !b) return 0;
    if (a->label.box.overlaps(b->label.box)) return covering;
    return in_conflict(*a, *b) ? crossing : 0;
  }

  /// Cost of a label at that position, with the others where they are.
  double cost_of(std::size_t label, const Choice& choice) const {
    double cost = own_cost(label, choice);
    const Candidate* own = chosen(label, choice);
    for (std::size_t i = 0; own && i < candidates_.size(); ++i) {
      if (i != label) cost += pair_cost(own, chosen(i, chosen_[i]));
    }
    return cost;
  }

  /// Whether the label has found another place.
  bool take_best(std::size_t label) {
    Choice best;
    double least = cost_of(label, best);
    for (std::size_t c = 0; c < candidates_[label].size(); ++c) {
      if (candidates_[label][c].cost >= least) continue;
      const double cost = cost_of(label, c);
      if (cost >= least) continue;
      least = cost;
      best = c;
    }
    if (best == chosen_[label]) return false;
    chosen_[label] = best;
    return true;
  }

  std::vector<std::vector<Candidate>> candidates_;
  std::vector<Choice> chosen_;
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
  Layout layout(std::move(candidates));
  layout.settle();
  Layout annealed = layout;
  annealed.anneal();
  annealed.settle();
  if (annealed.cost() < layout.cost()) layout = std::move(annealed);
  std::vector<std::optional<PlacedLabel>> out;
  for (std::size_t i = 0; i < labels.size(); ++i) out.push_back(layout[i]);
  return out;
}

}  // namespace ertbench
