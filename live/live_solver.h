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
#include "frames/frame_bounds.h"
#include "frames/reference_check.h"
#include "solvers/front/quiet_reference.h"
#include "solvers/solver.h"

namespace ertbench {

struct KnownTouch {
  FrameReading reading;
  double force_N = 0;
};

/// Estimates the total force from an image, as the study of sensitivity does: inverts the integral
/// of δσ over the sheet, fitted for each region as a monotone function of the force. Values beyond
/// the calibrated forces give the nearest of them.
class ForceReader {
 public:
  ForceReader(const TouchRegions& regions, const std::vector<KnownTouch>& touches);
  /// Nothing if the image shows no contact or its region was not calibrated.
  std::optional<double> force_N(const FrameReading& reading) const;

 private:
  const TouchRegions& regions_;
  ForceCalibration calibration_;
};

/// The collision signal of the study of collisions: compares the largest |δσ| of an image with a
/// threshold for the region of its contact.
class CollisionSignal {
 public:
  /// `quiet`: readings of successive frames without contact.
  CollisionSignal(const TouchRegions& regions, const std::vector<FrameReading>& quiet,
                  const FrameRuns& runs, double false_alarms_per_hour);
  bool alarm(const FrameReading& reading) const;

 private:
  const TouchRegions& regions_;
  std::vector<double> thresholds_;
};

/// The results of one frame.
struct LiveAnswer {
  Images image;  ///< [1, pixels] S/m; NaN if there is no usable image
  FrameReport report;
  FrameReading reading;            ///< contacts in mm from the origin of the domain units
  std::vector<TrackPoint> tracks;  ///< mm from the sheet's centre, the oldest first
  std::optional<double> force_N;   ///< of all contacts; nothing if unknown
  std::optional<bool> alarm;       ///< nothing without thresholds
  double solver_s = 0;             ///< time from the raw voltages to the image
};

/// Processes one frame after the other: image, contacts, tracks, force, alarm. Not thread-safe.
class LiveSolver {
 public:
  /// `solver` is fitted and for this sensor.
  LiveSolver(const Sensor& sensor, std::shared_ptr<const Solver> solver, const ContactRule& rule);

  /// `voltages` [channels] V without contact; must be set before the first frame.
  void set_reference(const Eigen::RowVectorXd& voltages);
  /// From now on frames are flagged whose solver does not know these dead electrodes.
  void set_dead(const std::vector<int>& electrodes) { bounds_.set_dead(electrodes); }
  const Eigen::RowVectorXd& reference() const { return reference_; }  ///< as set
  const Frames& expected() const { return expected_; }  ///< [1, channels] V, after mending
  /// Takes another solver for this sensor from the next frame on.
  void use(std::shared_ptr<const Solver> solver);
  /// From now on frames and reference are read as the verdict on the reference says.
  void mend(const ReferenceVerdict& verdict);

  /// From now on the reference follows level and gradient of the sheet while nothing presses.
  void follow_reference() { quiet_.emplace(sensor_); }

  /// Calibrates forces with frames of one touch each; `changes` [frames, channels] V from their
  /// reference, `forces_N` [frames].
  void learn_forces(FramesView changes, const std::vector<double>& forces_N);
  /// Fits the alarm's thresholds to frames without contact.
  void learn_quiet(FramesView changes, const FrameRuns& runs, double false_alarms_per_hour);

  /// `time_s` must be later than that of the frame before.
  const LiveAnswer& answer(const Eigen::Ref<const Eigen::RowVectorXd>& voltages, double time_s);

  const Sensor& sensor() const { return sensor_; }

 private:
  Frames mended(FramesView changes) const;
  /// Sets `expected_` from the reference.
  void expect();
  /// Computes image, report and contacts of the frame in `change_` into `answer_`; solvers with a
  /// stream of their own start from the last frame.
  void image();
  /// Makes the next frame independent of the last.
  void begin_sequence();

  Sensor sensor_;
  std::shared_ptr<const Solver> solver_;
  std::unique_ptr<FrameStream> stream_;
  FrameBounds bounds_;
  std::vector<Eigen::Matrix2d> twins_;  ///< symmetries of the sheet that no voltages show
  ContactRule rule_;
  ContactReader reader_;
  std::unique_ptr<TouchRegions> regions_;
  std::unique_ptr<ForceReader> forces_;
  std::unique_ptr<CollisionSignal> collision_;
  Tracker tracker_;
  std::optional<QuietReference> quiet_;
  Eigen::RowVectorXd reference_;
  Frames expected_;        ///< [1, channels] V, the reference after mending
  std::vector<int> from_;  ///< as in ReferenceVerdict; empty if nothing is mended
  Eigen::VectorXd factor_;
  Frames change_;
  std::vector<std::vector<FoundContact>> found_;
  LiveAnswer answer_;
};

}  // namespace ertbench
