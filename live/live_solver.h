#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "bench/score/image_contacts.h"
#include "bench/score/tracker.h"
#include "bench/studies/alarm_thresholds.h"
#include "bench/studies/sensitivity.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// The regions into which the sheet's symmetries divide it (see area_orbits), and which of them a
/// frame is about.
class TouchRegions {
 public:
  explicit TouchRegions(const Sensor& sensor);

  /// The area in which the strongest contact lies, without one the centroid of the image; nothing
  /// where the image shows nothing.
  std::optional<int> area(const FrameReading& reading) const;
  const std::vector<int>& region_of() const { return region_of_; }  ///< [areas]
  std::vector<double> shares() const;                               ///< [regions] of all areas

 private:
  Sensor sensor_;
  std::vector<int> region_of_;
};

/// A frame whose force is known.
struct KnownTouch {
  FrameReading reading;
  double force_N = 0;
};

/// From what an image says to the force of all touches together, as the study of sensitivity does:
/// the integral of δσ over the sheet, region by region made monotone in the force and read
/// backwards. Beyond the forces that it was made with their ends stand.
class ForceReader {
 public:
  ForceReader(const TouchRegions& regions, const std::vector<KnownTouch>& touches);
  /// Nothing where the image shows no touch, or one where no force was known.
  std::optional<double> force_N(const FrameReading& reading) const;

 private:
  const TouchRegions& regions_;
  ForceCalibration calibration_;
};

/// The collision signal of the study of collisions: the largest |δσ| of an image against a
/// threshold for the region of its touch.
class CollisionSignal {
 public:
  /// `quiet`: what was read out of frames in which nothing touches, one after the other.
  CollisionSignal(const TouchRegions& regions, const std::vector<FrameReading>& quiet,
                  const FrameRuns& runs, double false_alarms_per_hour);
  bool alarm(const FrameReading& reading) const;
  const std::vector<double>& thresholds() const { return thresholds_; }  ///< [regions] S/m

 private:
  const TouchRegions& regions_;
  std::vector<double> thresholds_;
};

/// All that is known of a frame in the end.
struct LiveAnswer {
  Images image;  ///< [1, pixels] S/m; not a number where there is no usable image
  FrameReport report;
  /// Of a frame without a usable image, or that is suspect because electrodes are dead in it, what
  /// there is; contacts in mm from the origin of the domain units.
  FrameReading reading;
  std::vector<TrackPoint> tracks;  ///< mm from the sheet's centre, the oldest first
  std::optional<double> force_N;   ///< of all touches; nothing where none, or none can be told
  std::optional<bool> alarm;       ///< nothing where there is no threshold
  double solver_s = 0;             ///< from the raw voltages to the image
};

/// What is done with one frame after the other: image, contacts, tracks, force, alarm. Not
/// thread-safe.
class LiveSolver {
 public:
  /// `solver` is fitted and for this sensor.
  LiveSolver(const Sensor& sensor, std::shared_ptr<const Solver> solver, const ContactRule& rule);

  /// [channels] V: must be there before the first frame.
  void set_reference(const Eigen::RowVectorXd& voltages) { reference_ = voltages; }
  const Eigen::RowVectorXd& reference() const { return reference_; }

  /// Forces from frames with one touch each; `changes` [frames, channels] V from their own
  /// reference, `forces_N` [frames].
  void learn_forces(FramesView changes, const std::vector<double>& forces_N);
  /// Thresholds from frames in which nothing touches.
  void learn_quiet(FramesView changes, const FrameRuns& runs, double false_alarms_per_hour);

  /// `time_s` must be later than that of the frame before.
  const LiveAnswer& answer(const Eigen::Ref<const Eigen::RowVectorXd>& voltages, double time_s);

  const Sensor& sensor() const { return sensor_; }
  const CollisionSignal* collision() const { return collision_.get(); }
  bool knows_forces() const { return forces_ != nullptr; }

 private:
  /// Image, report and contacts of the frame in `change_`, into `answer_`; a solver that can goes
  /// on from the frame before.
  void image();
  /// The next frame follows no other.
  void begin_sequence();

  Sensor sensor_;
  std::shared_ptr<const Solver> solver_;
  std::unique_ptr<FrameStream> stream_;
  ContactRule rule_;
  ContactReader reader_;
  std::unique_ptr<TouchRegions> regions_;
  std::unique_ptr<ForceReader> forces_;
  std::unique_ptr<CollisionSignal> collision_;
  Tracker tracker_;
  Eigen::RowVectorXd reference_;
  Frames change_;
  std::vector<std::vector<FoundContact>> found_;
  LiveAnswer answer_;
};

}  // namespace ertbench
