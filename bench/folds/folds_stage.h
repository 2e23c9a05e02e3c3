#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/experiment/study_spec.h"
#include "bench/run/stage.h"

namespace ertbench {

/// One press that nobody had seen, and where a solver put it; mm from the origin of the domain
/// units.
struct HeldOutPress {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  double strength = 0;                      ///< 1 - conductivity ratio of the true contact
  std::optional<Eigen::Vector2d> found_mm;  ///< nothing where no contact was detected
  /// Integral of |δσ| over the detected contact, over that of a contact of the true one's size and
  /// ratio 0; 0 where none was found.
  double found_strength = 0;

  bool operator==(const HeldOutPress&) const = default;
};

/// Results of a solver that learned from `presses`, on the share held out.
struct FoldRun {
  std::uint64_t presses = 0;
  std::string message;  ///< why it could not be fitted; else empty
  double fit_s = 0;
  std::vector<HeldOutPress> held_out;
};

/// `{"schema", "key", "runs": [{"presses", "message", "fit_s", "held_out": [[x, y, strength, found
/// x, found y, found strength], ...]}]}` of one fold, nulls where nothing was found.
using FoldRecord = std::vector<FoldRun>;

/// Hash of everything that the record depends on.
std::string fold_key(const FitRecipe& recipe, const Folds& folds, int fold,
                     const nlohmann::json& contacts);

/// Without the key.
nlohmann::json to_json(const FoldRecord& record);
/// Throws an exception of any kind where the JSON is not such a record.
FoldRecord fold_record_from_json(const nlohmann::json& object);

/// Outcome of one label's folds: [folds] of its first seed.
struct FoldsOutcome {
  std::string label;
  std::vector<FoldRecord> folds;  ///< those that were run
  std::string failure;            ///< of the first that was not; else empty
};

/// Cross-validation on measured frames (Folds), a job for each solver and fold. A study
/// (bench/studies) is made of what comes out.
class FoldsStage final : public Stage {
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
};

}  // namespace ertbench
