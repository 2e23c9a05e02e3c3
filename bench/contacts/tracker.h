#pragma once

#include <span>
#include <vector>

#include "bench/contacts/constant_velocity.h"
#include "forward/sheet/sheet.h"
#include "solvers/solver.h"

namespace ertbench {

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

}  // namespace ertbench
