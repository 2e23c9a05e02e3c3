#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/studies/alarm_thresholds.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"
#include "forward/touch/touch_sequence.h"

/// An arm whose skin runs into an obstacle (D.5), by the alarms that a detector raised.
namespace ertbench {

struct ArmSettings {
  double stiffness_N_mm = 5;
  double deceleration_m_s2 = 5;
  double aim_N = 10;
  double limit_N = 140;
  double clearance_mm = 10;  ///< to which the arm retreats from the obstacle
  double aside_mm = 50;      ///< by which it then passes

  /// Force on the obstacle when the arm stands still: it goes on at `speed_m_s` until the alarm and
  /// then decelerates, while the force grows with every millimetre.
  double peak_force_N(double speed_m_s, double delay_s) const;
  /// Time that stopping and going around costs over going straight on, for an obstacle into which
  /// the arm went `way_m`: it decelerates, retreats to the clearance, moves aside, passes and moves
  /// back, each way from rest to rest with the deceleration as its acceleration too.
  double detour_s(double speed_m_s, double way_m) const;
  /// From rest to rest, at most at `speed_m_s`.
  double travel_s(double speed_m_s, double way_m) const;
  /// Distance that the arm still moves after the onset.
  double way_m(double speed_m_s, double delay_s) const;
  /// Up to which speed a skin without any delay would stay under the aim.
  double highest_speed_m_s() const;
};

struct RaisedAlarm {
  double time_s = 0;       ///< when it is known
  double frame_end_s = 0;  ///< when its frame was measured
};

/// The first alarm of a sequence. A frame is looked at from its end on, or when the solver is done
/// with the one before, which takes `latency_s` >= 0 each; of the frames that came meanwhile only
/// the newest is. `alarms` [frames].
std::optional<RaisedAlarm> first_alarm_time(std::span<const char> alarms, const FrameTiming& timing,
                                            double latency_s);

/// The true course of a sequence.
struct ArmTruth {
  double onset_s = 0;
  double speed_m_s = 0;
};

/// One run of the arm into the obstacle.
struct ArmRun {
  ArmTruth truth;
  bool needless_stop = false;  ///< an alarm by a frame that ended before anything touched
  /// From the onset to the alarm, s; nothing where there is none, or the arm had stopped already.
  std::optional<double> delay_s;
  double of_latency_s = 0;       ///< the part of the delay that a solver of no latency would save
  std::optional<double> peak_N;  ///< nothing where there is no delay
  std::optional<double> lost_s;  ///< by the stop and the way around; also of a needless stop
  bool done = false;             ///< alarmed, under the limit, not stopped needlessly
};

/// The run of a skin that raises its alarm so long after the onset: at 0 no skin can do better.
ArmRun delayed_run(double delay_s, const ArmTruth& truth, const ArmSettings& settings);
ArmRun arm_run(std::span<const char> alarms, const FrameTiming& timing, double latency_s,
               const ArmTruth& truth, const ArmSettings& settings);

/// Outcome of all runs of a detector. Statistics of delay and force are over the runs without a
/// needless stop. A run without an alarm has an endless delay and the limit for its force, or more.
struct ArmOutcome {
  static constexpr double never_s = 1e6;  ///< stands for an endless delay

  std::vector<ArmRun> runs;
  std::optional<Estimate> median_delay_s, p95_delay_s;  ///< never_s where there is none
  std::optional<Estimate> latency_share;                ///< of the sum of the delays
  std::optional<Estimate> median_peak_N, p95_peak_N;    ///< at most the limit, standing for more
  std::optional<Estimate> mean_lost_s;                  ///< over the runs that stopped
  CountedShare under_aim, under_limit;                  ///< of runs without a needless stop
  CountedShare done, needless;                          ///< of all runs
  /// The highest speed up to which 95 % of the runs stay under the aim, m/s: at the upper end of
  /// its reach "this or more", under the lower end "nowhere".
  std::optional<LeastFound> highest_speed_m_s;
};

/// `name` keys the intervals' random numbers.
ArmOutcome arm_outcome(std::vector<ArmRun> runs, const ArmSettings& settings,
                       const std::string& name);

}  // namespace ertbench

/// Collision detectors and their scores.
namespace ertbench {

/// The signal and the thresholds that raise an alarm.
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

/// True courses of the four sets that the study reads.
struct CollisionTruth {
  std::vector<double> region_shares;  ///< [regions] of the sheet's area
  FrameRuns calibration;
  FrameRuns quiet;
  std::vector<PressTruth> presses;  ///< [frames]
  FrameRuns arm;
  FrameTiming arm_timing;
  std::vector<ArmTruth> arm_runs;  ///< [sequences]
};

/// A detector's signals in the frames of each set.
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
  std::optional<LeastFound> least_N;      ///< force detected in 95 % of the presses
  std::vector<std::optional<LeastFound>> least_by_region_N;  ///< [regions]
  ArmOutcome arm;

  std::string name() const;  ///< "one-step-gn, by region"
};

/// All that the study's tables and figures show.
struct CollisionResults {
  std::string condition;  ///< "falling law, 50 dB absolute"; with the noises where they differ
  double per_hour = 10;   ///< false alarms that were asked for
  ArmSettings arm;
  double frame_rate = 125;        ///< of the arm's frames, 1/s
  double calibration_hours = 0;   ///< of quiet frames
  std::vector<int> region_areas;  ///< [regions] how many of the areas
  /// Both rules of each solver, in the order of the experiment, then the norm of the voltages.
  std::vector<Detector> detectors;
  ArmOutcome undelayed;  ///< of a skin that raises its alarm at the very onset
};

/// Thresholds by the calibration frames alone, then everything else. `per_hour` false
/// alarms are asked for; regions get a share of them in proportion to their area.
Detector assess_detector(const std::string& label, AlarmRule rule, const DetectorSignals& signals,
                         const CollisionTruth& truth, double per_hour,
                         std::optional<double> latency_s, const ArmSettings& arm);

/// D.5: did we hit something? Alarms by the largest |δσ| of an image, with thresholds that are set
/// on frames in which nothing touches; what they miss, how often they are false, and what becomes
/// of an arm that stops by them.
Study collision_study(const StudyInput& input);

/// False alarms, thresholds, least forces and the arm's runs; CSV files of these, and of what the
/// figures show.
void add_collision_tables(const CollisionResults& results, StudySection& section);
/// All numbers, for summary.json.
nlohmann::json collision_json(const CollisionResults& results);

/// Peak force against speed.
StudyFigure collision_figure(const std::shared_ptr<const CollisionResults>& results);

}  // namespace ertbench
