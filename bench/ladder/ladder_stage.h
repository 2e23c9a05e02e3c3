#pragma once

#include <filesystem>
#include <functional>

#include "bench/experiment/ladder_spec.h"
#include "bench/experiment/solver_entry.h"
#include "bench/ladder/ladder_record.h"
#include "bench/record/cache.h"
#include "bench/run/stage.h"

namespace ertbench {

class SolverRegistry;

/// Evaluates the recipe's solver (cached, or fitted now) on all ladders that concern it and judges
/// every frame. Levels are variants of the test set `base`, generated in memory; solvers of
/// parameter axes and their training sets are cached.
LadderRecord climb_ladders(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base,
                           const Cache& cache, SolverRegistry& registry, int threads,
                           const std::filesystem::path& progress_file);

/// Evaluates the axis's levels, then bisects the step in which the share of failing frames first
/// exceeds `limit`: six times, or on an integer axis down to neighbouring numbers. Axes without an
/// order and those of parameters are not bisected. Returns the levels from the mildest.
std::vector<LadderLevel> climb_ladder(
    const LadderAxis& axis, double limit,
    const std::function<LadderLevel(const Level& level)>& evaluate);

/// Finds where every solver fails on the experiment's ladders, one job per label (climb_ladders).
class LadderStage : public Stage {
 public:
  std::string name() const override;
  std::string noun() const override;
  std::vector<Job> jobs(const Experiment& experiment) const override;
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override;
  std::string key(const Experiment& experiment, const Job& job) const override;
  nlohmann::json run(const Job& job, const JobContext& context) const override;
  void check(const Experiment& experiment, const nlohmann::json& record) const override;
  void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
               ExperimentResults& results) const override;
  std::vector<ReportSection> report(const Experiment& experiment, const ExperimentResults& results,
                                    const std::filesystem::path& folder) const override;
};

}  // namespace ertbench
