#pragma once

#include <Eigen/Core>
#include <cstdint>
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

/// What a solver did at one level.
struct LadderLevel {
  Level level;
  std::vector<JudgedFrame> frames;  ///< none where the solver could not be made at this level
  std::string message;              ///< why not

  double share() const;  ///< of failing frames; 1 where there are none
  int count(FailureKind kind) const;
  /// What failed here, in the form that breakdown.h takes: `frames` frames, all of which failed
  /// where there was no solver.
  LadderStep step(std::size_t frames) const;
};

/// A frame to look at, taken from the level where the solver breaks down: of the kind of failure
/// that is most frequent there, the frame in which it is worst.
struct WorstFrame {
  Level level;
  int frame = 0;
  FailureKind kind = FailureKind::undefined;
  JudgedFrame judged;
  Eigen::RowVectorXd conductivity;  ///< [pixels] S/m, the truth
  Eigen::RowVectorXd change;        ///< [pixels] S/m, the image; NaN where it was not finite
};

/// What a solver did on one axis.
struct LadderClimb {
  std::string axis;
  std::vector<LadderLevel> levels;  ///< from the mildest, those of the bisection among them
  std::optional<WorstFrame> worst;
};

/// `{"schema", "key", "base": {level}, "axes": [{"axis", "levels": [{"level", "error", "distance",
/// "peak", "status", "failed": [frames], "message"}], "worst": {...}}]}`, numbers with five digits.
/// "status" is the solver's FrameStatus: 0 ok, 1 not converged, 2 undefined, 3 suspect; "failed"
/// the sum of 1 undefined, 2 worse than the empty image, 4 misplaced, 8 false positive.
struct LadderRecord {
  LadderLevel base;  ///< of the test set itself
  std::vector<LadderClimb> axes;

  const LadderClimb* find(const std::string& axis) const;
};

/// What became of one solver's ladders.
struct LadderOutcome {
  const SolverEntry* entry = nullptr;
  std::optional<LadderRecord> record;
  std::string failure;  ///< where there is none: "crashed: Aborted; see ..."
};
using LadderOutcomes = std::vector<LadderOutcome>;

/// What determines the record: the solver, the test set that all levels are variants of, the rule
/// of failure and the axes that concern the solver.
std::string ladder_key(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base);

/// Without the key.
nlohmann::json to_json(const LadderRecord& record);
/// Throws an exception of any kind where the JSON is not such a record.
LadderRecord ladder_record_from_json(const nlohmann::json& object);

}  // namespace ertbench
