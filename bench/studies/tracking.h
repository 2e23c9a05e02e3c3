#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/score/tracker.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {

/// A frame as a solver gets it, and the contacts that it detected.
struct StreamFrame {
  double middle_s = 0;  ///< of its drives: the contacts' places are those of this time
  double end_s = 0;     ///< when all of its voltages are there
  std::vector<Eigen::Vector2d> contacts_mm;  ///< from the sheet's centre, the strongest first
};

/// The knowledge from a moment on, until the next report.
struct StreamReport {
  std::size_t frame = 0;  ///< that it is made from
  double out_s = 0;
  /// Where the finger was in the middle of the frame, if anywhere: the confirmed track that a
  /// contact of the frame belongs to, of several the oldest; in a frame without any contact the
  /// oldest confirmed track, where it should be by now.
  std::optional<Eigen::Vector2d> place_mm;
  std::vector<Eigen::Vector2d> seen_mm;  ///< of all confirmed tracks that the frame shows
};

/// Feeds the frames of a sequence, in their order, to a solver that takes `latency_s` for each and
/// to a tracker behind it. A frame that ends while the solver is busy waits; a newer one takes its
/// place. One report for each frame that was worked on.
std::vector<StreamReport> follow_stream(std::span<const StreamFrame> frames, double latency_s);

/// Reads characters by the nearest of forward/touch/characters.h (nearest_shape).
class CharacterReader {
 public:
  /// `size_mm`: of the box around a character.
  explicit CharacterReader(double size_mm);

  /// "A"; empty where no stroke has a point.
  std::string read(std::span<const Polyline> strokes) const;

 private:
  std::vector<Polyline> shapes_;
};

/// One written character, and what came of it. Values that are not defined are absent.
struct TrackedCharacter {
  std::string name;               ///< what was written
  std::vector<Polyline> written;  ///< [strokes] mm from the sheet's centre
  /// [strokes] the places reported of those frames in the middle of which the finger was down.
  std::vector<Polyline> tracked;

  // Root mean square distance of the positions known at equally distant moments, those of the
  // latest report, from the finger's at the same moment, and from the finger's `lag_s` before.
  std::optional<double> rms_mm;
  std::optional<double> rms_without_lag_mm;
  std::optional<double> lag_s;
  /// The largest of the strokes' discrete Fréchet distances; absent where a stroke has no place.
  std::optional<double> frechet_mm;
  std::string read_as;  ///< empty where nothing was tracked

  int frames = 0;
  int worked_on = 0;  ///< the others were dropped, as the solver was busy
  int touched = 0;    ///< of those worked on: the finger was down in the middle of the frame
  int lost = 0;       ///< of the touched ones: no place was reported
  /// Confirmed tracks that a frame showed while nothing touched during it, or farther than
  /// kGhostDistance from the finger; over all frames worked on.
  int ghosts = 0;

  bool read_back() const { return read_as == name; }
};

inline constexpr double kGhostDistance = 40;  ///< mm

/// Frames of the sequence `truth` as a solver of this latency gets them.
TrackedCharacter track_character(const TouchSequence& truth, std::span<const StreamFrame> frames,
                                 double latency_s, const CharacterReader& reader);

/// Scores over one solver's characters; absent where none has such a value. Intervals: of means and
/// ratios by the bootstrap over characters (all repeats of one together), of the share read back
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
  std::optional<Estimate> ghosts;          ///< false positives in a frame worked on; may be above 1
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

/// The least sufficient frame rates for one solver at one speed and noise, of two or more.
struct EnoughFrameRate {
  std::string label;
  double speed_mm_s = 0;
  std::string noise;
  std::vector<double> frame_rates;      ///< that were tried, ascending
  std::optional<double> for_reading;    ///< by the share read back
  std::optional<double> for_the_place;  ///< by the RMS distance
};

/// Ordered by solver, then by noise and speed.
std::vector<EnoughFrameRate> enough_frame_rates(std::span<const TrackingCondition> conditions);

/// D.4: along which path? A finger writes characters; the places that a solver's contacts and a
/// tracker give are held against those of the finger, at the time at which they are known.
Study tracking_study(const StudyInput& input);

/// A row a solver.
TableSection tracking_table(const TrackingCondition& condition, const std::string& law);

/// The least sufficient frame rate: a row a solver, a column a speed; none where no speed was
/// measured at two frame rates or more.
std::vector<TableSection> frame_rate_tables(std::span<const TrackingCondition> conditions,
                                            const std::string& law);

/// The CSV file: a row for each condition and solver.
TableSection tracking_data(std::span<const TrackingCondition> conditions, const std::string& law);

using TrackingConditions = std::shared_ptr<const std::vector<TrackingCondition>>;
/// Written and tracked characters of the first condition, a column a solver.
StudyFigure tracking_figure(const TrackingConditions& conditions, const std::string& law);

}  // namespace ertbench
