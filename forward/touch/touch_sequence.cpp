#include "forward/touch/touch_sequence.h"

#include <algorithm>

namespace ertbench {

Touch TouchPath::at(double time_s) const {
  Touch touch{indenter, Eigen::Vector2d::Zero(), 0};
  if (points.empty() || time_s < points.front().time_s || time_s > points.back().time_s) {
    return touch;
  }
  const auto next =
      std::upper_bound(points.begin(), points.end(), time_s,
                       [](double time, const PathMoment& point) { return time < point.time_s; });
  if (next == points.begin() || next == points.end()) {
    const PathMoment& end = next == points.end() ? points.back() : points.front();
    return {indenter, end.place_mm, end.force_N};
  }
  const PathMoment& before = *std::prev(next);
  const double part = (time_s - before.time_s) / (next->time_s - before.time_s);
  touch.place_mm = before.place_mm + part * (next->place_mm - before.place_mm);
  touch.force_N = before.force_N + part * (next->force_N - before.force_N);
  return touch;
}

std::vector<Touch> TouchSequence::at(double time_s) const {
  std::vector<Touch> touches;
  touches.reserve(paths.size());
  for (const TouchPath& path : paths) touches.push_back(path.at(time_s));
  return touches;
}

}  // namespace ertbench
