#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "forward/sheet/sheet.h"
#include "solvers/solver.h"

namespace ertbench {

/// Kalman filter of a point with constant velocity and a random acceleration, constant within a
/// step and independent between steps. The noise is isotropic, so that x and y share one covariance
/// and one gain. Lengths in mm, times in s.
class ConstantVelocity {
 public:
  /// Starts at a measured position with zero mean velocity and the given standard deviations.
  ConstantVelocity(const Eigen::Vector2d& place_mm, double place_deviation_mm,
                   double speed_deviation_mm_s);

  /// Advances by `step_s` with this standard deviation of the acceleration along each axis.
  void predict(double step_s, double acceleration_deviation_mm_s2);

  /// Updates with the present position, measured with this standard deviation along each axis.
  void update(const Eigen::Vector2d& place_mm, double place_deviation_mm);

  Eigen::Vector2d place_mm() const { return state_.row(0); }
  Eigen::Vector2d velocity_mm_s() const { return state_.row(1); }
  /// Covariance of (position, velocity) along either axis: mm^2, mm^2/s, mm^2/s^2.
  const Eigen::Matrix2d& covariance() const { return covariance_; }

 private:
  Eigen::Matrix2d state_;  ///< (place, velocity) of x in the first column, of y in the second
  Eigen::Matrix2d covariance_;
};

/// Positions of detected contacts, mm from the sheet's centre.
std::vector<Eigen::Vector2d> centred_places_mm(std::span<const FoundContact> contacts,
                                               const Sheet& sheet);

/// State of a track at the time of a frame.
struct TrackPoint {
  int id = 0;  ///< counted from 0, never reused
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_mm_s = Eigen::Vector2d::Zero();
  bool confirmed = false;
  bool seen = false;  ///< detected in this frame; else the position is predicted
};

/// Tracks contacts over time. Contacts of each frame are assigned to tracks, each a Kalman filter,
/// with the least sum of distances from the predicted positions. Unassigned contacts start new
/// tracks.
class Tracker {
 public:
  /// Adds a frame with its contacts, mm from the sheet's centre; returns all tracks, including
  /// unconfirmed ones, the oldest first. Throws std::invalid_argument unless the frame is later
  /// than the one before.
  std::vector<TrackPoint> update(double time_s, std::span<const Eigen::Vector2d> places_mm);

 private:
  struct Track {
    int id;
    ConstantVelocity motion;
    double last_seen_s;
    int frames = 1;  ///< since its first, inclusive
    int frames_seen = 1;
    int frames_missed = 0;  ///< since its last detection
    bool confirmed = false;
  };

  static void take_in(Track& track, double time_s, const Eigen::Vector2d* place_mm);
  static bool is_over(const Track& track, double time_s);

  std::vector<Track> tracks_;
  double time_s_ = 0;
  int next_id_ = 0;
};

/// Points joined by straight lines, mm.
using Polyline = std::vector<Eigen::Vector2d>;

double length_of(const Polyline& line);

/// Resamples a polyline at the largest equal spacing of at most `step` > 0, including both ends. A
/// polyline without length stays one point.
Polyline resampled(const Polyline& line, double step);

/// Discrete Fréchet distance (Eiter & Mannila 1994), mm: the shortest leash with which two walkers
/// get from the first points to the last, each from point to point and never back. Neither may be
/// empty. It approximates the distance of the lines up to the spacing of the points: resample
/// first.
double frechet_distance(const Polyline& a, const Polyline& b);

/// Dynamic time warping (Sakoe & Chiba 1978, symmetric form without slope constraint), mm: the mean
/// distance of aligned points under the best alignment, with weight 2 for steps of both lines and 1
/// for steps of one. Neither may be empty.
double warped_distance(const Polyline& a, const Polyline& b);

/// Normalises strokes for nearest_shape: each resampled at `step` mm, concatenated without pen-up
/// moves, and centred at the mean of all points. The size is kept: shapes are drawn at a known
/// size, and a method that shrinks them has an error.
Polyline centred_shape(std::span<const Polyline> strokes, double step);

/// Index of the shape with the least warped distance. `shapes` must not be empty and come from
/// centred_shape with the same step.
std::size_t nearest_shape(const Polyline& shape, std::span<const Polyline> shapes);

/// A tracked position with its time.
struct PathPoint {
  double time_s = 0;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
};

/// The true position at a time, mm; no value while the pen is up.
using TruePlace = std::function<std::optional<Eigen::Vector2d>(double time_s)>;

/// Root mean square distance between tracked points and the true position `lag_s` earlier, mm, over
/// the points with a true position; no value without one.
std::optional<double> rms_distance(std::span<const PathPoint> tracked, const TruePlace& truth,
                                   double lag_s);

struct LagFit {
  double lag_s = 0;   ///< delay of the tracked points
  double rms_mm = 0;  ///< rms_distance at that lag
};

/// The lag with the least rms_distance from 0 to `most_s`: a scan in `steps` (>= 2) equal steps,
/// refined by a parabola through the mean squares around the best. All lags are compared over the
/// same points, those with a true position at every lag; no value without such points.
std::optional<LagFit> best_lag(std::span<const PathPoint> tracked, const TruePlace& truth,
                               double most_s, int steps);

}  // namespace ertbench
