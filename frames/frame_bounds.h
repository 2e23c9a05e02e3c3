#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "frames/reference_check.h"
#include "solvers/solver.h"

namespace ertbench {

/// Faults of a frame's voltages, as bits of FrameReport::reasons beside the FrameReason's, of which
/// `unexplained` is one, too: contacts on this sheet do not explain the change.
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
  bool even = false;        ///< the level is wrong in all channels alike, as by a gain
  int channel = -1;         ///< that alone makes the frame unexplained; -1: it is not one
  int electrode = -1;       ///< that reads zero in the frame alone; -1: none does
  double step = 0;          ///< V to which the voltages are rounded, if that is too coarse

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
/// dead channels hardly move it. Within these bounds, frames are flagged whose channels have all
/// the same ratio, more than five per cent from 1 (contacts change some channels much more than
/// others), of whose change less than three quarters lie in the ContactSpan, a single channel of
/// which lies outside it, an electrode of which reads zero, or that are rounded as coarsely as they
/// change.
class FrameBounds {
 public:
  explicit FrameBounds(const Sensor& sensor);

  /// Judges a frame by its change from `reference`, both [channels] in one unit. Channels of the
  /// dead electrodes that the solver `said` are left out if others remain, and a change of the
  /// whole sheet that it estimated is no fault.
  FrameVerdict judge(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                     const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                     const FrameReport& said = {}) const;
  /// Judges each of several references [frames, channels] by its change from their median.
  std::vector<FrameVerdict> judge_references(const Frames& references) const;

  /// Electrodes that read zero in the reference: frames are flagged whose solver does not know
  /// them.
  void set_dead(const std::vector<int>& electrodes);
  /// Norm of the noise of a frame relative to the reference, by default 0.02: parts of a change
  /// that are twice as large must be explained by contacts.
  void set_noise(double noise) { noise_ = noise; }

 private:
  /// Sets the levels and the change to those of the discs.
  void find_extremes(const Sensor& sensor);
  void judge_levels(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                    const Eigen::Ref<const Eigen::RowVectorXd>& reference, const FrameReport& said,
                    FrameVerdict& verdict) const;
  /// Flags voltages that are rounded so coarsely that contacts change them by little more.
  void judge_rounding(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                      const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                      FrameVerdict& verdict) const;
  /// Enters the electrode that reads zero in this frame, other than those `known` to.
  void judge_electrodes(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                        const Eigen::Ref<const Eigen::RowVectorXd>& reference, ElectrodeSet known,
                        FrameVerdict& verdict) const;
  void judge_rest(const Eigen::Ref<const Eigen::RowVectorXd>& change, double size,
                  FrameVerdict& verdict) const;

  std::vector<ElectrodeSet> electrodes_;  ///< [channels] of drive and measurement
  ContactSpan span_;
  double noise_ = 0.02;
  ElectrodeSet dead_ = 0;  ///< in the reference
  double least_level_ = 1;
  double most_level_ = 1;
  double most_change_ = 0;
};

/// Throws InputError that begins with `source` and names the frames [N, channels] V without contact
/// that are unlike the others (check_quiet); the first is called `from`.
void require_quiet(const Sensor& sensor, const Frames& frames, const std::string& source,
                   std::uint64_t from = 0);

/// The median of each column.
Eigen::RowVectorXd median_of_rows(const Frames& frames);

/// Enters a verdict into the report of a frame. A frame without a usable image stays undefined.
void report(const FrameVerdict& verdict, FrameReport& report);

}  // namespace ertbench
