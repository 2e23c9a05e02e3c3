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

/// Takes the recipe's solver (from the cache, or fitted) up all ladders that concern it and judges
/// every frame. `base` is the test set that all levels are variants of. Levels are made in memory;
/// solvers of parameter axes and their training sets go to the cache.
LadderRecord climb_ladders(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base,
                           const Cache& cache, SolverRegistry& registry, int threads,
                           const std::filesystem::path& progress_file);

/// Evaluates the axis's own levels, then halves the step in which the share of failing frames first
/// exceeds `limit`: six times, or on an integer axis down to neighbouring numbers. Without an order
/// or of a parameter, the axis's own levels alone. Returns them from the mildest.
std::vector<LadderLevel> climb_ladder(
    const LadderAxis& axis, double limit,
    const std::function<LadderLevel(const Level& level)>& evaluate);

/// Takes every fitted solver up the experiment's ladders, to where it breaks down. A job of its own
/// for each label, see climb_ladders.
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
