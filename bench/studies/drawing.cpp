#include "bench/studies/drawing.h"

#include "core/text.h"

namespace ertbench {

using Eigen::Vector2d;

Points points_of(const std::vector<Vector2d>& places, const Vector2d& origin) {
  Points out;
  for (const Vector2d& place : places) {
    out.emplace_back(place.x() - origin.x(), place.y() - origin.y());
  }
  return out;
}

void add_footnote(Canvas& canvas, const std::string& text, double left) {
  canvas.text(text, left, canvas.height() - 10, {.size = 9, .align = TextAlign::left});
}

void add_failure(Canvas& canvas, const Box& box, const std::string& failure) {
  if (failure.empty()) return;
  canvas.text(one_line(failure, 34), box.middle(), box.centre(), {.size = 9, .colour = ink::alarm});
}

void Series::add(double x, const std::optional<Estimate>& estimate) {
  if (!estimate) return;
  points.emplace_back(x, estimate->value);
  whiskers.push_back({x, estimate->ci95.low, estimate->ci95.high});
}

void Series::draw(Panel& panel, const LineStyle& line, const MarkStyle& mark,
                  const LineStyle& whisker) const {
  panel.line(points, line);
  panel.whiskers(whiskers, whisker);
  panel.marks(points, mark);
}

}  // namespace ertbench
