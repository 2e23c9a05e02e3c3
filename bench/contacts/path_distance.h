#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace ertbench {

/// Points in their order, mm; two that follow each other are joined by a straight line.
using Polyline = std::vector<Eigen::Vector2d>;

double length_of(const Polyline& line);

/// Points at equal distances along the polyline, both its ends among them, of which there are as
/// few as bring the distance to `step` > 0 or less. A polyline without length stays one point.
Polyline resampled(const Polyline& line, double step);

/// Discrete Fréchet distance (Eiter & Mannila 1994), mm: the shortest leash with which two walkers
/// get from the first points to the last, each from point to point and never back. Neither may be
/// empty. It is that of the lines but for the distances of the points along them: resample first.
double frechet_distance(const Polyline& a, const Polyline& b);

/// Dynamic time warping (Sakoe & Chiba 1978, symmetric form without slope constraint), mm: the mean
/// distance of the points that the best alignment puts beside each other, the steps of which weigh
/// 2 where both go on and 1 where one does. Neither may be empty.
double warped_distance(const Polyline& a, const Polyline& b);

/// Strokes as nearest_shape compares them: each at steps of `step` mm, one behind the other without
/// what the pen did in the air, measured from the mean of all points. The place counts for nothing,
/// the size does: shapes are drawn at a known one, and a method that shrinks them has an error.
Polyline centred_shape(std::span<const Polyline> strokes, double step);

/// The shape of the least warped distance; `shapes` has one at least, all made by centred_shape
/// with the same step.
std::size_t nearest_shape(const Polyline& shape, std::span<const Polyline> shapes);

/// Where something was tracked, and when.
struct PathPoint {
  double time_s = 0;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
};

/// The true place at a time, mm; none where the pen is up.
using TruePlace = std::function<std::optional<Eigen::Vector2d>(double time_s)>;

/// Root mean square of the distances of tracked points from where the truth was `lag_s` earlier,
/// mm, over those points that have such a truth; nothing where none has.
std::optional<double> rms_distance(std::span<const PathPoint> tracked, const TruePlace& truth,
                                   double lag_s);

struct LagFit {
  double lag_s = 0;   ///< by which the tracked points are late
  double rms_mm = 0;  ///< rms_distance with that lag
  int points = 0;     ///< of which it is
};

/// The lag of least rms_distance between `least_s` and `most_s`, by a scan of so many equal `steps`
/// (>= 2) and a parabola through the mean squares around the best. All lags are compared over the
/// same points, those that have a truth at each of them; nothing where there are none.
std::optional<LagFit> best_lag(std::span<const PathPoint> tracked, const TruePlace& truth,
                               double least_s, double most_s, int steps = 100);

}  // namespace ertbench
