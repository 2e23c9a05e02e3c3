#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/studies/error_statistics.h"
#include "bench/studies/tracking_run.h"

namespace ertbench {

/// Of one solver's characters; absent where none has such a value. Intervals: of means and ratios
/// by the bootstrap over characters (all repeats of one together), of the share read back
/// Wilson's.
struct TrackingScores {
  // Means over the characters that have the value (TrackedCharacter).
  std::optional<Estimate> rms_mm;
  std::optional<Estimate> rms_without_lag_mm;
  std::optional<Estimate> lag_ms;
  std::optional<Estimate> frechet_mm;
  int with_rms = 0;  ///< characters that have it
  int with_lag = 0;
  int with_frechet = 0;
  // Ratios of sums over all characters.
  std::optional<Estimate> drop_outs;       ///< of the frames worked on while the finger was down
  std::optional<Estimate> dropped_frames;  ///< of all frames
  std::optional<Estimate> ghosts;          ///< in a frame worked on; may be above 1
  std::optional<Estimate> read_back;       ///< of all characters
};

/// `key` names the intervals' random numbers.
TrackingScores tracking_scores(std::span<const TrackedCharacter> characters,
                               const std::string& key);

/// One solver under one condition.
struct TrackingOfSolver {
  std::string label;
  std::string failure;              ///< why nothing was tracked; else empty
  std::optional<double> latency_s;  ///< nothing: not measured, and taken as 0
  std::vector<TrackedCharacter> characters;
  TrackingScores scores;
};

/// One test set: a finger of one speed, seen at one frame rate.
struct TrackingCondition {
  std::string set;
  double speed_mm_s = 0;
  double frame_rate = 0;  ///< 1/s
  double size_mm = 0;     ///< of the box around a character
  std::string touch;      ///< "ellipse of 8 x 10 mm, 2 N"
  std::string noise;      ///< "50 dB absolute"
  std::vector<TrackingOfSolver> solvers;
};

/// A frame rate and what was measured at it.
struct RateValue {
  double frame_rate = 0;
  std::optional<double> value;
};

/// The least frame rate whose value is within 5 % of the best one; nothing where none has a value,
/// or the best is a share of 0. `most_is_best`: as of shares, unlike errors.
std::optional<double> enough_frame_rate(std::span<const RateValue> rates, bool most_is_best);

/// Which frame rate is enough for one solver at one speed and noise, of two or more.
struct EnoughFrameRate {
  std::string label;
  double speed_mm_s = 0;
  std::string noise;
  std::vector<double> frame_rates;      ///< that were tried, ascending
  std::optional<double> for_reading;    ///< by the share read back
  std::optional<double> for_the_place;  ///< by the RMS distance
};

/// By solver, then by noise and speed.
std::vector<EnoughFrameRate> enough_frame_rates(std::span<const TrackingCondition> conditions);

}  // namespace ertbench
