#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "forward/sheet/sheet.h"
#include "solvers/solver.h"

namespace ertbench {

/// Kalman filter of a point that moves with constant velocity but for a random acceleration, which
/// is independent from each step to the next and constant within it. The noise is the same in all
/// directions, so that x and y have one covariance and one gain. Lengths in mm, times in s.
class ConstantVelocity {
 public:
  /// At a measured place, of a velocity that is 0 but for the standard deviations.
  ConstantVelocity(const Eigen::Vector2d& place_mm, double place_deviation_mm,
                   double speed_deviation_mm_s);

  /// Goes on by `step_s` under an acceleration of this standard deviation along each axis.
  void predict(double step_s, double acceleration_deviation_mm_s2);

  /// Takes in where the point was `ago_s` before the present time, measured with this standard
  /// deviation along each axis.
  void update(const Eigen::Vector2d& place_mm, double ago_s, double place_deviation_mm);

  Eigen::Vector2d place_mm() const { return state_.row(0); }
  Eigen::Vector2d velocity_mm_s() const { return state_.row(1); }
  /// Of (place, velocity) along either axis: mm^2, mm^2/s, mm^2/s^2.
  const Eigen::Matrix2d& covariance() const { return covariance_; }

 private:
  Eigen::Matrix2d state_;  ///< (place, velocity) of x in the first column, of y in the second
  Eigen::Matrix2d covariance_;
};

/// A contact of a frame as the tracker takes it.
struct TimedContact {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< from the sheet's centre
  /// By how much the contact was there before the frame's time, s: a frame takes milliseconds.
  double ago_s = 0;
};

/// The contacts that a solver found, in millimetres from the sheet's centre.
std::vector<TimedContact> timed_contacts(std::span<const FoundContact> contacts,
                                         const Sheet& sheet);

struct TrackerSettings {
  double acceleration_mm_s2 = 5000;  ///< standard deviation along each axis
  double measurement_mm = 3;         ///< standard deviation of a contact's place along each axis
  double speed_mm_s = 500;           ///< standard deviation of a new contact's velocity, each axis
  double gate_mm = 40;  ///< a contact farther than this from where a track should be is not its own
  int confirm_frames = 2;   ///< frames that must show a new track before it counts; 1: at once
  int confirm_window = 3;   ///< ... of so many from the first on; else it is forgotten
  double patience_s = 0.1;  ///< without a contact, after which a track ends ...
  int patience_frames = 2;  ///< ... and not before so many frames without one
};

/// Where a track is at the time of a frame.
struct TrackPoint {
  int id = 0;  ///< counted from 0, never used again
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_mm_s = Eigen::Vector2d::Zero();
  /// Of (place, velocity) along either axis: mm^2, mm^2/s, mm^2/s^2.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  bool confirmed = false;
  bool seen = false;  ///< in this frame; else the place is where the track should be by now
};

/// Follows contacts over time: the contacts of each frame are assigned to the tracks, each a Kalman
/// filter, so that the distances from where those should be are the least in sum. What belongs to
/// no track begins one.
class Tracker {
 public:
  /// Throws std::invalid_argument where a setting makes no sense.
  explicit Tracker(const TrackerSettings& settings = {});

  /// Takes in a frame, later than the one before (std::invalid_argument); returns all tracks there
  /// are after it, the oldest first, also those that are not confirmed yet.
  std::vector<TrackPoint> update(double time_s, std::span<const TimedContact> contacts);

 private:
  struct Track {
    int id;
    ConstantVelocity motion;
    double last_seen_s;
    int frames = 1;  ///< since its birth, that frame included
    int frames_seen = 1;
    int frames_missed = 0;  ///< since it was last seen
    bool confirmed = false;
  };

  void take_in(Track& track, double time_s, const TimedContact* contact) const;
  bool is_over(const Track& track, double time_s) const;

  TrackerSettings settings_;
  std::vector<Track> tracks_;
  double time_s_ = 0;
  int next_id_ = 0;
};

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
