#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "bench/contacts/contact_rule.h"
#include "bench/contacts/frame_reading.h"
#include "bench/contacts/image_contacts.h"
#include "bench/contacts/tracker.h"
#include "bench/live/touch_force.h"
#include "solvers/solver.h"

namespace ertbench {

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
