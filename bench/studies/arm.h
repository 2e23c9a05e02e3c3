#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/studies/detection_share.h"
#include "bench/studies/error_statistics.h"
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
  /// What stopping and going around takes longer than going straight on, for an obstacle into which
  /// the arm went `way_m`: it decelerates, retreats to the clearance, moves aside, passes and moves
  /// back, each way from rest to rest with the deceleration as its acceleration too.
  double detour_s(double speed_m_s, double way_m) const;
  /// From rest to rest, at most at `speed_m_s`.
  double travel_s(double speed_m_s, double way_m) const;
  /// How far the arm goes on after the onset.
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

/// What happened in a sequence before anything was measured.
struct ArmTruth {
  double onset_s = 0;
  double duration_s = 0;
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

/// The run of a skin that raises its alarm at the very onset: no skin can do better.
ArmRun undelayed_run(const ArmTruth& truth, const ArmSettings& settings);
ArmRun arm_run(std::span<const char> alarms, const FrameTiming& timing, double latency_s,
               const ArmTruth& truth, const ArmSettings& settings);

/// What all runs of a detector came to. Statistics of delay and force are over the runs without a
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
