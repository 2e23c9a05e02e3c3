#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace ertbench {

/// What failed at one level of a ladder.
struct LadderStep {
  double level = 0;
  std::vector<std::uint8_t> failed;  ///< [frames] 0 or 1; the same frames at every level

  double share() const;  ///< of failing frames
};

enum class BreakState {
  breaks,      ///< within the ladder
  at_mildest,  ///< has broken down at the first level already
  never,       ///< has not at the last
};

/// What is taken to happen between two levels: the share runs straight in the level or in its
/// logarithm, or, as nothing lies between, the second level is the first that fails.
enum class Between { linear, logarithmic, nothing };

/// Where on a ladder a solver breaks down: where the share of failing frames first crosses a limit.
struct Breakdown {
  BreakState state = BreakState::never;
  double level = 0;  ///< of the crossing; the first level or the last where it is not between them
  double place = 0;  ///< of the crossing along the ladder, 0 at its first level ... 1 at its last
  /// Ends of the 95 % interval, the milder and the severer; none where it leaves the ladder there.
  std::optional<double> mild;
  std::optional<double> severe;
};

inline constexpr int kBreakdownResamples = 1000;

/// `ladder`: from the mildest level to the severest, strictly rising or falling, two at least, with
/// the same number of frames, one at least. The interval is the percentile bootstrap's over the
/// frames, a resample being the same at all levels (frames are paired); its random numbers are
/// keyed by `name`. Throws std::invalid_argument where the ladder is none.
Breakdown break_down(std::span<const LadderStep> ladder, double share, Between between,
                     std::string_view name);

/// For a parameter, which may be too small as well as too large: from the best level to either end.
struct WorkingRange {
  std::size_t best = 0;  ///< the level with the fewest failures, the middle one of several
  /// Towards the first level and towards the last; none where the best level is that end.
  std::optional<Breakdown> to_first;
  std::optional<Breakdown> to_last;
};

WorkingRange working_range(std::span<const LadderStep> ladder, double share, Between between,
                           std::string_view name);

}  // namespace ertbench
