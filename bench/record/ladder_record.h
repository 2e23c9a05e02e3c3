#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/fit_recipe.h"
#include "bench/experiment/ladder_spec.h"
#include "bench/score/breakdown.h"
#include "bench/score/frame_failure.h"

namespace ertbench {

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
/// the sum of 1 undefined, 2 worse than nothing, 4 misplaced, 8 contact where there is none.
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

/// What determines the record: the solver, the test set that all levels are variants of, the rule
/// of failure and the axes that concern the solver.
std::string ladder_key(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base);

/// Without the key.
nlohmann::json to_json(const LadderRecord& record);
/// Throws an exception of any kind where the JSON is not such a record.
LadderRecord ladder_record_from_json(const nlohmann::json& object);

}  // namespace ertbench
