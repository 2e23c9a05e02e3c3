#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Faults of a frame's voltages, as bits of FrameReport::reasons beside the FrameReason's.
enum FrameFault : std::uint8_t {
  turned_sign = 16,        ///< the voltages have the opposite sign of the reference's
  wrong_level = 32,        ///< their level is none that contacts can give
  impossible_change = 64,  ///< no contacts can change voltages so much
  wrong_reference = 128,   ///< the frame's own reference is unlike those of the other frames
};

/// What FrameBounds makes of one frame.
struct FrameVerdict {
  std::uint8_t faults = 0;  ///< set of FrameFault
  double level = 1;         ///< of the voltages, relative to the reference's
  double change = 0;        ///< norm of the change over that of the reference

  /// "its level is 1000 times the reference's (millivolts for volts?)"; empty without a fault.
  std::string text() const;
};

/// The voltages that contacts on a sheet can cause at all, relative to the reference voltages. The
/// bounds are those of the sensor's model with discs that insulate or conduct perfectly, wherever
/// they fit, with a margin for several: half as much again of the level, three times the change.
/// Needs neither a solver nor frames to fit to.
///
/// Insulating discs reach 0.6 of the sheet's inner radius and conducting ones 0.8. The level is the
/// median of the ratios of the channels, weighted by the reference: contacts near electrodes and
/// dead channels hardly move it.
class FrameBounds {
 public:
  explicit FrameBounds(const Sensor& sensor);

  /// Judges a frame by its change from `reference`, both [channels] in one unit. Channels of the
  /// `dead` electrodes are left out if others remain.
  FrameVerdict judge(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                     const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                     ElectrodeSet dead = 0) const;
  /// Judges each of several references [frames, channels] by its change from their median.
  std::vector<FrameVerdict> judge_references(const Frames& references) const;

  double least_level() const { return least_level_; }
  double most_level() const { return most_level_; }
  double most_change() const { return most_change_; }

 private:
  std::vector<ElectrodeSet> electrodes_;  ///< [channels] of drive and measurement
  double least_level_ = 1;
  double most_level_ = 1;
  double most_change_ = 0;
};

/// The median of each column.
Eigen::RowVectorXd median_of_rows(const Frames& frames);

/// Enters a verdict into the report of a frame. A frame without a usable image stays undefined.
void report(const FrameVerdict& verdict, FrameReport& report);

}  // namespace ertbench
