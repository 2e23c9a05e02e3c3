#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bench/studies/alarm_thresholds.h"
#include "bench/studies/arm.h"
#include "bench/studies/detection_share.h"

/// What tells that a skin was run into, and how well it does.
namespace ertbench {

/// By what an alarm is raised.
enum class AlarmRule {
  by_region,      ///< largest |δσ| of the image, a threshold for the region it lies in
  one_threshold,  ///< the same, one threshold for the whole sheet
  voltage_norm,   ///< 2-norm of the voltages' change from the reference: no solver
};
const char* name_of(AlarmRule rule);

/// One frame of a touch at rest.
struct PressTruth {
  double force_N = 0;  ///< 0: nothing touches, the frame does not count
  int region = 0;
  std::size_t scene = 0;  ///< frames of the same scene are no independent trials
};

/// What truly happened in the four sets that the study reads.
struct CollisionTruth {
  std::vector<double> region_shares;  ///< [regions] of the sheet's area
  FrameRuns calibration;
  FrameRuns quiet;
  std::vector<PressTruth> presses;  ///< [frames]
  FrameRuns arm;
  FrameTiming arm_timing;
  std::vector<ArmTruth> arm_runs;  ///< [sequences]
};

/// What a detector looks at in the frames of each set.
struct DetectorSignals {
  AlarmSignal calibration;
  AlarmSignal quiet;
  AlarmSignal presses;
  AlarmSignal arm;
};

/// False alarms of frames in which nothing touches.
struct FalseAlarms {
  int alarms = 0;
  double hours = 0;

  double per_hour() const { return alarms / hours; }
  Interval ci95() const;  ///< of a Poisson count
};

/// One setting of a detector whose thresholds are all multiplied by a factor.
struct OperatingPoint {
  double factor = 1;
  FalseAlarms quiet;
  CountedShare found;  ///< of the presses with about the reference force
};

/// One detector, and all that came out of it.
struct Detector {
  std::string label;  ///< of the solver
  AlarmRule rule = AlarmRule::by_region;
  std::string failure;                     ///< why there is nothing else; else empty
  std::optional<double> latency_s;         ///< of the solver; nothing where it was not measured
  std::vector<AlarmThreshold> thresholds;  ///< [regions], or one
  FalseAlarms quiet;
  std::optional<Estimate> quiet_alarmed;  ///< share of the quiet frames that are in alarm
  std::size_t undefined_presses = 0;      ///< frames with a touch and without a usable image
  std::vector<ShareBin> by_force;         ///< N; the same bins for all detectors
  std::optional<LeastFound> least_N;      ///< found in 95 % of the presses
  std::vector<std::optional<LeastFound>> least_by_region_N;  ///< [regions]
  std::vector<OperatingPoint> curve;                         ///< the highest factor first
  ArmOutcome arm;

  std::string name() const;  ///< "one-step-gn, by region"
};

/// All that the study's tables and figures show.
struct CollisionResults {
  std::string condition;  ///< "falling law, 50 dB absolute"; with the noises where they differ
  double per_hour = 10;   ///< false alarms that were asked for
  ArmSettings arm;
  double frame_rate = 125;               ///< of the arm's frames, 1/s
  double calibration_hours = 0;          ///< of quiet frames
  std::vector<int> region_areas;         ///< [regions] how many of the areas
  std::optional<std::size_t> reference;  ///< bin of force that the operating curves are of
  /// Both rules of each solver, in the order of the experiment, then the norm of the voltages.
  std::vector<Detector> detectors;
  ArmOutcome undelayed;  ///< of a skin that raises its alarm at the very onset
};

/// Thresholds by the calibration frames alone, then everything but the curve. `per_hour` false
/// alarms are asked for; regions get a share of them in proportion to their area.
Detector assess_detector(const std::string& label, AlarmRule rule, const DetectorSignals& signals,
                         const CollisionTruth& truth, double per_hour,
                         std::optional<double> latency_s, const ArmSettings& arm);

/// The bin of `by_force` that tells detectors apart best: the share found there, over all of them,
/// is nearest to a half. Nothing where no detector has any.
std::optional<std::size_t> reference_bin(const std::vector<Detector>& detectors);

/// False alarms and presses found in the bin, by threshold factor. Factors so low that alarms run
/// into each other, and become fewer by a tenth and more, are left out.
std::vector<OperatingPoint> operating_curve(const Detector& detector,
                                            const DetectorSignals& signals,
                                            const CollisionTruth& truth, const ShareBin& bin);

}  // namespace ertbench
