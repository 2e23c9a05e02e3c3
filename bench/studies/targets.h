#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/score/image_contacts.h"
#include "bench/score/metric_formulas.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The truth of a frame: the contacts whose centroids lie on the sheet.
struct TargetFrame {
  std::size_t scene = 0;  ///< frames of the same number show the same scene
  /// Whether the frame is one of those by which numbers of contacts are compared.
  bool counts = true;
  std::vector<Eigen::Vector2d> places_mm;  ///< from the sheet's centre
  std::vector<double> radii_mm;            ///< of the circles around the footprints

  int contacts() const { return static_cast<int>(places_mm.size()); }
  /// Between the two circles, to the millionth of a mm, so that gaps that were asked for are equal
  /// in all scenes; negative where they overlap. Nothing unless there are two contacts.
  std::optional<double> gap_mm() const;
};

TargetFrame target_frame(const Sensor& sensor, const Scene& scene, std::size_t number);

/// Clears `counts` of the frames of sets in which every frame has two contacts, where another set
/// has frames with two as well: such sets hold pairs at gaps of their own choice, which are
/// narrower or wider than those between three or four contacts. `sets` [frames] numbers their sets.
void leave_out_pair_sets(std::span<TargetFrame> frames, std::span<const std::size_t> sets);

/// Matches the detected contacts with the true ones.
ContactScore match_targets(const TargetFrame& truth, std::span<const ContactReading> found,
                           const ContactDistances& distances);

/// Sums over frames.
struct TargetTally {
  int frames = 0;
  int right_frames = 0;  ///< with exactly as many contacts detected as there are
  int there = 0;
  int found = 0;
  int matched = 0;
  double distance_mm = 0;
  double ospa_mm = 0;

  void add(const ContactScore& score);
  TargetTally& operator+=(const TargetTally& other);
};

/// A number by which solvers are compared; its sums are over all frames ("micro" averages), so that
/// a frame in which nothing was detected has its part in it.
struct TargetMetric {
  std::string key;      ///< in summary.json: "precision"
  std::string heading;  ///< of its column, with the unit
  int decimals;
  std::optional<double> (*of)(const TargetTally&);  ///< nothing where nothing is divided
};

/// precision, recall, f1, ghosts, right_number, location_error_mm, ospa_mm.
const std::vector<TargetMetric>& target_metrics();

/// One solver's frames with the same number of true contacts.
struct TargetCount {
  int frames = 0;
  int scenes = 0;
  std::map<std::string, std::optional<Estimate>> metrics;  ///< all of target_metrics(), by key
};

/// Scores by number of true contacts, over the frames with `counts` and a score. `scores` [frames]:
/// nothing where the solver did not get that far.
///
/// Intervals are the bootstrap's over scenes, the same scenes for every solver; resamples in which
/// a number is undefined do not enter. The share of frames with the right number has Wilson's
/// interval where every scene has one frame.
std::map<int, TargetCount> count_targets(std::span<const TargetFrame> frames,
                                         std::span<const std::optional<ContactScore>> scores);

/// Share of resolved scenes from which on a gap counts as resolved.
inline constexpr double kResolvedShare = 0.8;
/// Scenes that must lie at a gap and above before it counts as resolved: the last few scenes alone
/// say little.
inline constexpr int kLeastResolvedScenes = 10;

/// A scene with two contacts.
struct GapTrial {
  double gap_mm = 0;
  int frames = 0;
  int told_apart = 0;  ///< frames in which both contacts were detected, each by one of its own

  double share() const { return double(told_apart) / frames; }
};

/// The scenes with two contacts, by gap. `scores` as in count_targets; also of frames that do not
/// count there.
std::vector<GapTrial> gap_trials(std::span<const TargetFrame> frames,
                                 std::span<const std::optional<ContactScore>> scores);

/// Share of resolved scenes in an interval of gaps.
struct GapBin {
  double low_mm = 0;   ///< included
  double high_mm = 0;  ///< not included
  double mean_gap_mm = 0;
  int scenes = 0;
  Estimate told_apart;  ///< Wilson's interval; of scenes with several frames the bootstrap's
};

/// The least gap from which on two contacts are resolved.
struct ResolvableGap {
  enum class State {
    resolved,      ///< at `gap_mm`
    always,        ///< at the least gap of the set already, which `gap_mm` is
    never,         ///< not within the set
    too_few_pairs  ///< fewer than kLeastResolvedScenes
  };
  State state = State::too_few_pairs;
  std::optional<double> gap_mm;
  /// 95 % interval by the bootstrap over scenes; an end without a value lies below the least or
  /// above the largest gap of the set.
  std::optional<double> low_mm, high_mm;

  /// "12.3", "≤ 2.0", "not within the set", "too few pairs".
  std::string text() const;
  /// "[9.8, 14.1]", "[< set, 14.1]", "[30.2, > set]"; empty without an interval.
  std::string interval() const;
};

/// One solver's pairs of contacts.
struct TargetGaps {
  int scenes = 0;
  double least_mm = 0;  ///< of all gaps
  double largest_mm = 0;
  std::vector<GapBin> bins;  ///< those with scenes
  ResolvableGap resolvable;
};

/// `trials` by gap. The resolvable gap is where the isotonic fit reaches kResolvedShare (its own
/// value, not a limit of its uncertainty), as long as kLeastResolvedScenes lie there and above.
TargetGaps measure_gaps(std::span<const GapTrial> trials);

const char* name_of(ResolvableGap::State state);

/// Contacts that a solver detected in the study's frames.
struct TargetReadings {
  std::string label;
  std::string failure;                     ///< why some are missing; else empty
  std::vector<const FrameReading*> found;  ///< [frames]; null where it did not get that far
};

/// One solver's part of the study.
struct TargetSolver {
  std::string label;
  std::string failure;                ///< why there is nothing, or not all; else empty
  std::map<int, TargetCount> counts;  ///< by number of true contacts
  TargetGaps gaps;
};

struct TargetResults {
  std::vector<int> numbers;  ///< of true contacts that are compared, ascending
  std::vector<TargetSolver> solvers;
};

/// Scores of each solver's contacts in the frames.
TargetResults target_results(std::span<const TargetFrame> frames,
                             std::span<const TargetReadings> readings,
                             const ContactDistances& distances);

/// Circumstances that tables and figures name.
struct TargetCircumstances {
  std::string name;        ///< of the study and its files
  std::string conditions;  ///< "falling law, 50 dB absolute"
  ContactDistances distances;
};

/// D.3: how many touch? Still touches, one or several at a time: which of them are detected, how
/// many false positives there are, and how close two may come before they are one.
Study targets_study(const StudyInput& input);
Study study_of_targets(const TargetCircumstances& circumstances, const TargetResults& results);

/// A row for each number of contacts and solver.
TableSection targets_count_table(const TargetCircumstances& circumstances,
                                 const TargetResults& results);
/// A row for each solver: the resolvable gap, and the share resolved by gap.
TableSection targets_gap_table(const TargetCircumstances& circumstances,
                               const TargetResults& results);
/// CSV files with all digits and intervals: a row for each solver, number of contacts and metric,
/// and a row for each solver and bin of gaps with one for the resolvable gap.
TableSection targets_count_data(const TargetResults& results);
TableSection targets_gap_data(const TargetResults& results);

/// Recall and false positives against the number of contacts, share resolved against the gap.
StudyFigure targets_chart(const TargetCircumstances& circumstances,
                          std::shared_ptr<const TargetResults> results);
}  // namespace ertbench
