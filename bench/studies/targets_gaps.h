#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/score/contact_score.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/targets_scores.h"
#include "core/interval.h"

namespace ertbench {

/// Share of scenes that are told apart from which on a gap counts as resolved.
inline constexpr double kResolvedShare = 0.8;
/// Scenes that must lie at a gap and above before it counts as resolved: the last few scenes alone
/// say little.
inline constexpr int kLeastResolvedScenes = 10;

/// A scene with two contacts.
struct GapTrial {
  double gap_mm = 0;
  int frames = 0;
  int told_apart = 0;  ///< frames in which both contacts were found, each by one of its own

  double share() const { return double(told_apart) / frames; }
};

/// The scenes with two contacts, by gap. `scores` as in count_targets; also of frames that do not
/// count there.
std::vector<GapTrial> gap_trials(std::span<const TargetFrame> frames,
                                 std::span<const std::optional<ContactScore>> scores);

/// An observation of a curve.
struct WeightedPoint {
  double x = 0;
  double y = 0;
  double weight = 1;
};

/// Observations that share their value in an isotonic fit.
struct IsotonicBlock {
  double first = 0;  ///< least x
  double last = 0;   ///< largest x
  double value = 0;
  double weight = 0;  ///< sum
};

/// The non-decreasing curve of least weighted squares through points by ascending x, by pooling
/// adjacent violators (Ayer et al. 1955); equal x share a block. Between two blocks the curve is
/// taken to be straight. Points without weight do not enter.
std::vector<IsotonicBlock> isotonic_fit(std::span<const WeightedPoint> points);

/// Share of scenes that were told apart, in an interval of gaps.
struct GapBin {
  double low_mm = 0;   ///< included
  double high_mm = 0;  ///< not included
  double mean_gap_mm = 0;
  int scenes = 0;
  Estimate told_apart;  ///< Wilson's interval; of scenes with several frames the bootstrap's
};

/// The least gap from which on two contacts are told apart.
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
  std::vector<GapBin> bins;        ///< those with scenes
  std::vector<IsotonicBlock> fit;  ///< of the share told apart against the gap
  ResolvableGap resolvable;
};

/// `trials` by gap. The resolvable gap is where the isotonic fit reaches kResolvedShare (its own
/// value, not a limit of its uncertainty), as long as kLeastResolvedScenes lie there and above.
TargetGaps measure_gaps(std::span<const GapTrial> trials);

const char* name_of(ResolvableGap::State state);

}  // namespace ertbench
