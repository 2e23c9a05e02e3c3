#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/experiment/ladder_spec.h"
#include "bench/experiment/solver_entry.h"
#include "bench/score/frame_failure.h"

namespace ertbench {

/// The failed frames at one level of a ladder.
struct LadderStep {
  double level = 0;
  std::vector<std::uint8_t> failed;  ///< [frames] 0 or 1; the same frames at every level

  double share() const;  ///< of failing frames
};

enum class BreakState {
  breaks,      ///< within the ladder
  at_mildest,  ///< already at the first level
  never,       ///< not even at the last level
};

/// Interpolation between two levels: the share is linear in the level or in its logarithm, or, if
/// no levels lie between, the second level is the first that fails.
enum class Between { linear, logarithmic, nothing };

/// The level at which a solver fails: where the share of failing frames first crosses a limit.
struct Breakdown {
  BreakState state = BreakState::never;
  double level = 0;  ///< of the crossing; the first or the last level if it is not between them
  double place = 0;  ///< position of the crossing, 0 at the first level ... 1 at the last
  /// The milder and the severer end of the 95 % interval; nothing if it leaves the ladder there.
  std::optional<double> mild;
  std::optional<double> severe;
};

inline constexpr int kBreakdownResamples = 1000;

/// `ladder` has two or more levels from the mildest to the severest, strictly rising or falling,
/// each with the same frames. The interval is the percentile bootstrap's over the frames, resampled
/// alike at all levels since frames are paired; its random numbers are keyed by `name`. Throws
/// std::invalid_argument if the ladder is invalid.
Breakdown break_down(std::span<const LadderStep> ladder, double share, Between between,
                     std::string_view name);

/// The range of a parameter, which may be too small as well as too large.
struct WorkingRange {
  std::size_t best = 0;  ///< the level with the fewest failures, the middle one of several
  /// Towards the first and towards the last level; nothing if the best level is that end.
  std::optional<Breakdown> to_first;
  std::optional<Breakdown> to_last;
};

WorkingRange working_range(std::span<const LadderStep> ladder, double share, Between between,
                           std::string_view name);

/// A solver's frames at one level.
struct LadderLevel {
  Level level;
  std::vector<JudgedFrame> frames;  ///< empty if the solver could not be made at this level
  std::string message;              ///< why not

  double share() const;  ///< of failing frames; 1 without frames
  int count(FailureKind kind) const;
  /// Input of break_down: `frames` frames, all of which failed if there was no solver.
  LadderStep step(std::size_t frames) const;
};

/// A solver's results on one axis.
struct LadderClimb {
  std::string axis;
  std::vector<LadderLevel> levels;  ///< from the mildest, including those of the bisection
};

/// `{"schema", "key", "base": {level}, "axes": [{"axis", "levels": [{"level", "error", "distance",
/// "peak", "status", "failed": [frames], "message"}]}]}`, numbers with five digits.
/// "status" is the solver's FrameStatus: 0 ok, 1 not converged, 2 undefined, 3 suspect; "failed"
/// the sum of 1 undefined, 2 worse than the empty image, 4 misplaced, 8 false positive.
struct LadderRecord {
  LadderLevel base;  ///< of the test set itself
  std::vector<LadderClimb> axes;

  const LadderClimb* find(const std::string& axis) const;
};

/// Evaluates the axis's levels, then bisects the step in which the share of failing frames first
/// exceeds `limit`: six times, or on an integer axis down to neighbouring numbers. Axes without an
/// order and those of parameters are not bisected. Returns the levels from the mildest.
std::vector<LadderLevel> climb_ladder(
    const LadderAxis& axis, double limit,
    const std::function<LadderLevel(const Level& level)>& evaluate);

struct LadderOutcome {
  const SolverEntry* entry = nullptr;
  std::optional<LadderRecord> record;
  std::string failure;  ///< why there is no record: "crashed: Aborted; see ..."
};
using LadderOutcomes = std::vector<LadderOutcome>;

/// Hash of everything that determines the record: the solver, the base test set, the failure rule
/// and the axes that concern the solver.
std::string ladder_key(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base);

/// The JSON lacks the key.
nlohmann::json to_json(const LadderRecord& record);
/// Throws some std::exception if the JSON is not such a record.
LadderRecord ladder_record_from_json(const nlohmann::json& object);

}  // namespace ertbench
