#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/features/parts.h"
#include "bench/ladder/ladder_record.h"
#include "bench/ladder/ladder_results.h"
#include "bench/record/cache.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/run/stage.h"
#include "core/errors.h"
#include "forward/data/dataset_file.h"
#include "forward/data/scene_model.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

constexpr int halvings = 6;

/// A test set in memory.
struct TestBlock {
  Frames changes;       ///< [frames, channels] V, from the recorded reference
  Images conductivity;  ///< [frames, pixels] S/m, the truth
  std::vector<Scene> scenes;
};

/// The test set that all levels are variants of.
const DatasetSpec& base_of(const Experiment& experiment) {
  return *experiment.find_dataset(experiment.ladders->dataset);
}

/// Evaluates a solver (cached, or fitted now) on all ladders that concern it and judges every
/// frame. Levels are variants of the test set, generated in memory; solvers of parameter axes and
/// their training sets are cached.
class Climber {
 public:
  Climber(const SolverEntry& entry, const JobContext& context)
      : context_(context),
        recipe_(fit_recipe(context.experiment, entry)),
        ladders_(*context.experiment.ladders),
        base_block_(block_of(base_of(context.experiment))),
        fitted_(fitted(recipe_)),
        progress_(context.progress_file) {
    for (const LadderAxis& axis : ladders_.axes) {
      if (axis.concerns(recipe_.entry)) total_ += axis.levels.size();
    }
  }

  LadderRecord run() {
    LadderRecord record;
    record.base = judged(*fitted_.solver, base_block_, Level());
    for (const LadderAxis& axis : ladders_.axes) {
      if (axis.concerns(recipe_.entry)) record.axes.push_back(climb(axis));
    }
    return record;
  }

 private:
  FittedSolver fitted(const FitRecipe& recipe) const {
    return fitted_solver(recipe, context_.cache, context_.registry, context_.threads,
                         context_.progress_file);
  }

  TestBlock block_of(const DatasetSpec& spec) {
    const auto model = models_.try_emplace(text_of(spec.model), spec.sensor, spec.model).first;
    DatasetBlock block = generate_block(spec, model->second, 0, spec.count);
    const Eigen::VectorXd reference =
        recorded_reference(spec.faults, model->second.reference_voltages());
    return {block.voltages.rowwise() - reference.transpose(), std::move(block.conductivity),
            std::move(block.truths)};
  }

  LadderClimb climb(const LadderAxis& axis) {
    const double limit = ladders_.failure.share;
    std::uint64_t own = 0;
    LadderClimb out{axis.name, {}};
    out.levels = climb_ladder(axis, limit, [&](const Level& level) {
      progress_.update(done_ + std::min<std::uint64_t>(own++, axis.levels.size()), total_,
                       axis.name + " " + level.text());
      return evaluate(axis, level);
    });
    done_ += axis.levels.size();
    return out;
  }

  LadderLevel evaluate(const LadderAxis& axis, const Level& level) {
    if (!axis.of_parameter()) {
      const DatasetSpec spec = dataset_at(ladders_, recipe_.sensor, axis, level);
      return judged(*fitted_.solver, block_of(spec), level);
    }
    try {
      return judged(*refitted(axis, level), base_block_, level);
    } catch (const std::exception& error) {
      return {level, {}, error.what()};
    }
  }

  LadderLevel judged(const Solver& solver, const TestBlock& block, const Level& level) const {
    Images images(block.changes.rows(), recipe_.sensor.pixels());  // unusable ones are NaN
    std::vector<FrameReport> reports(static_cast<std::size_t>(images.rows()));
    solver.reconstruct(block.changes, images, reports);
    LadderLevel out{level, {}, ""};
    for (Eigen::Index i = 0; i < images.rows(); ++i) {
      const auto f = static_cast<std::size_t>(i);
      out.frames.push_back(judge(recipe_.sensor, ladders_.failure, block.scenes[f],
                                 block.conductivity.row(i), images.row(i), reports[f].status));
    }
    return out;
  }

  /// The solver with the level's parameter or training set.
  std::unique_ptr<Solver> refitted(const LadderAxis& axis, const Level& level) {
    FitRecipe recipe = recipe_;
    recipe.entry = entry_at(recipe_.entry, axis, level);
    recipe.training = training_at(ladders_, recipe_.sensor, axis, level);
    if (recipe.training) ensure_dataset(*recipe.training, context_.cache, context_.threads);
    return fitted(recipe).solver;
  }

  const JobContext& context_;
  FitRecipe recipe_;
  const Ladders& ladders_;
  std::map<std::string, SceneModel> models_;  ///< by text_of their model
  TestBlock base_block_;
  FittedSolver fitted_;
  ProgressFile progress_;
  std::uint64_t done_ = 0;  ///< levels of the file
  std::uint64_t total_ = 0;
};

/// Finds where every solver fails on the experiment's ladders, one job per label.
class LadderStage final : public Stage {
 public:
  std::string name() const override { return "ladders"; }
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override {
    if (!experiment.ladders) return {};
    std::vector<Job> due = jobs(experiment);
    std::erase_if(due, [&](const Job& job) {
      return results.labels.at(job.entry->label).scored != job.entry;
    });
    return due;
  }
  std::string key(const Experiment& experiment, const Job& job) const override {
    return ladder_key(fit_recipe(experiment, *job.entry), *experiment.ladders, base_of(experiment));
  }
  nlohmann::json run(const Job& job, const JobContext& context) const override {
    return to_json(Climber(*job.entry, context).run());
  }
  void check(const Experiment&, const nlohmann::json& record) const override {
    ladder_record_from_json(record);
  }
  void collect(const Experiment& experiment, const Cache&, const JobRecords& records,
               ExperimentResults& results) const override {
    if (!experiment.ladders) return;
    for (const std::span<const SolverEntry> entries : experiment.rows()) {
      const LabelOutcome& label = results.labels.at(entries.front().label);
      LadderOutcome& outcome = results.findings.of<LadderOutcomes>().emplace_back();
      outcome.entry = label.scored ? label.scored : &entries.front();
      outcome.failure = label.failure;
      if (!label.scored) continue;
      const Job job = job_of(*this, *label.scored);
      if (const auto record = records.read(job)) {
        outcome.record = ladder_record_from_json(*record);
      } else {
        outcome.failure = records.why_missing(job).text();
      }
    }
  }
  std::vector<ReportSection> report(const Experiment& experiment, const ExperimentResults& results,
                                    const std::filesystem::path& folder) const override {
    return write_ladder_results(experiment, results.findings.found<LadderOutcomes>(),
                                results.builds, folder);
  }
};

}  // namespace

std::vector<LadderLevel> climb_ladder(
    const LadderAxis& axis, double limit,
    const std::function<LadderLevel(const Level& level)>& evaluate) {
  std::vector<LadderLevel> levels;
  for (const Level& level : axis.levels) levels.push_back(evaluate(level));
  if (axis.categories || axis.of_parameter()) return levels;
  const auto exceeds = [&](const LadderLevel& level) { return level.share() > limit; };
  auto severe = std::ranges::find_if(levels, exceeds);
  if (severe == levels.begin() || severe == levels.end()) return levels;
  for (int i = 0; axis.integer || i < halvings; ++i) {
    const double a = std::prev(severe)->level.number();
    const double b = severe->level.number();
    if (axis.integer && std::abs(b - a) <= 1) break;
    const double middle = axis.logarithmic ? std::sqrt(a * b) : (a + b) / 2;
    // On a logarithmic axis the rounded middle may equal an end.
    const long whole = std::clamp(std::lround(std::floor(middle)), std::lround(std::min(a, b)) + 1,
                                  std::lround(std::max(a, b)) - 1);
    const Level value = axis.integer ? Level(nlohmann::json(whole)) : Level(middle);
    severe = levels.insert(severe, evaluate(value));
    if (!exceeds(*severe)) ++severe;
  }
  return levels;
}

}  // namespace ertbench

extern "C" void ertbench_part_ladders(ertbench::Part& part) {
  part.stages = [](int) {
    ertbench::Stages stages;
    stages.push_back(std::make_unique<ertbench::LadderStage>());
    return stages;
  };
}
