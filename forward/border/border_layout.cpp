#include "forward/border/border_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "forward/border/corner_grading.h"

namespace ertbench {
namespace {

constexpr int least_open = 6;
constexpr int most_on_arc = 240;
/// Largest distance between points over that to whatever is next to them.
constexpr double largest_spacing = 1.5;
/// An arc that would need more points than this is cut where it needs them.
constexpr int most_before_cut = 36;
constexpr int passes = 8;

/// The far side of an ellipse is two minor semi-axes away.
int least(const ContactArc& arc) {
  const int around =
      std::max(9, static_cast<int>(std::min<double>(most_on_arc, 2.1 * arc.piece.elongation())));
  if (arc.closed) return around;
  const double share = (arc.end - arc.begin) / arc.piece.length();
  return std::max(least_open, static_cast<int>(around * share));
}

/// Of each arc the largest spacing, in units of the allowed one, and the point where that is.
struct Demand {
  double spacing = 0;
  int point = 0;
};

std::vector<Demand> demands(const std::vector<ContactArc>& arcs, const BorderPoints& points,
                            const Eigen::Array2Xd& electrodes) {
  // At a corner or a junction neighbours come as close as they like, and the grading is there for
  // that: there only the middle halves of the arcs count.
  const auto is_middle = [&](std::size_t arc, Eigen::Index i) {
    const double place = (static_cast<double>(i) - points.first[arc] + 0.5) /
                         (points.first[arc + 1] - points.first[arc]);
    return std::abs(place - 0.5) < 0.25;
  };
  std::vector<Demand> out(arcs.size());
  for (std::size_t a = 0; a < arcs.size(); ++a) {
    std::vector<char> joined(arcs.size(), 0);
    for (std::size_t b = 0; b < arcs.size(); ++b) joined[b] = are_joined(arcs[a], arcs[b]);
    const bool touches_sheet = arcs[a].begins_at_sheet || arcs[a].ends_at_sheet;
    for (Eigen::Index i = points.first[a]; i < points.first[a + 1]; ++i) {
      const bool middle = is_middle(a, i);
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t b = 0; b < arcs.size(); ++b) {
        if (b == a || (joined[b] && !middle)) continue;
        for (Eigen::Index j = points.first[b]; j < points.first[b + 1]; ++j) {
          if (joined[b] && !is_middle(b, j)) continue;
          const double dx = points.x[i] - points.x[j];
          const double dy = points.y[i] - points.y[j];
          nearest = std::min(nearest, dx * dx + dy * dy);
        }
      }
      const double square =
          ((electrodes.row(0) - points.x[i]).square() + (electrodes.row(1) - points.y[i]).square())
              .minCoeff();
      nearest = std::sqrt(std::min(nearest, square));
      if (middle || !touches_sheet) nearest = std::min(nearest, points.depth[i]);
      const double spacing = points.weight[i] / (largest_spacing * nearest);
      if (spacing > out[a].spacing) out[a] = {spacing, static_cast<int>(i)};
    }
  }
  return out;
}

}  // namespace

BorderLayout border_layout(const Sheet& sheet, const Eigen::Array2Xd& electrodes,
                           const Scene& scene, BorderCuts cuts) {
  BorderLayout layout{contact_arcs(scene, sheet), {}};
  set_gradings(sheet, layout.arcs);
  for (const ContactArc& arc : layout.arcs) layout.counts.push_back(least(arc));
  for (int pass = 0; pass < passes; ++pass) {
    const BorderPoints points = border_points(sheet, layout.arcs, layout.counts);
    const std::vector<Demand> wanted = demands(layout.arcs, points, electrodes);
    BorderLayout next;
    bool changed = false;
    for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
      const ContactArc& arc = layout.arcs[a];
      const int count = layout.counts[a];
      const int more = std::min(
          most_on_arc, static_cast<int>(std::ceil(count * std::min(wanted[a].spacing, 1e3))));
      if (more <= count) {
        next.arcs.push_back(arc);
        next.counts.push_back(count);
        continue;
      }
      changed = true;
      const double where =
          graded_parameter(arc, wanted[a].point - points.first[a], count).parameter;
      const double edge = 0.05 * (arc.end - arc.begin);  // nearer to an end the grading serves
      if (cuts == BorderCuts::none || more <= most_before_cut ||
          (!arc.closed && (where < arc.begin + edge || where > arc.end - edge))) {
        next.arcs.push_back(arc);
        next.counts.push_back(more);
      } else if (arc.closed) {
        next.arcs.push_back(arc);
        next.arcs.back().begin = where;
        next.arcs.back().end = where + arc.piece.length();
        next.arcs.back().closed = false;
        next.counts.push_back(least(next.arcs.back()));
      } else {
        for (const bool first : {true, false}) {
          next.arcs.push_back(arc);
          ContactArc& part = next.arcs.back();
          (first ? part.end : part.begin) = where;
          (first ? part.ends_at_sheet : part.begins_at_sheet) = false;
          next.counts.push_back(least(part));
        }
      }
    }
    layout = std::move(next);
    if (!changed) break;
  }
  return layout;
}

}  // namespace ertbench
