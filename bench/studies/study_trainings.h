#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/record/study_result.h"

namespace ertbench {

/// One headline of a solver that was trained more than once.
struct HeadlineSpread {
  std::string label;
  std::string what;
  int decimals = 2;
  std::vector<std::optional<double>> values;  ///< [trainings]

  std::optional<double> mean() const;       ///< of the trainings that have a value
  std::optional<double> deviation() const;  ///< sample standard deviation; of two values at least
};

/// `of_trainings` [trainings] are the headlines of each; of the later ones those of the solvers
/// that were trained so often, which are the ones that have a spread.
std::vector<HeadlineSpread> spread_of(std::span<const std::vector<Headline>> of_trainings);

/// A study of the first training of each solver, and what the other trainings make of its
/// headlines: what is the method's, and what one training's luck.
class StudyTrainings : public StudyResult {
 public:
  StudyTrainings(std::string name, std::shared_ptr<const StudyResult> first,
                 std::vector<HeadlineSpread> spread)
      : name_(std::move(name)), first_(std::move(first)), spread_(std::move(spread)) {}

  /// The first training's, with `"trainings": [{"solver", "what", "values", "mean", "deviation"}]`.
  nlohmann::json summary() const override;
  std::vector<Headline> headlines() const override { return first_->headlines(); }
  /// The first training's, then a section on the others, also as NAME_trainings.md and .csv.
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string name_;
  std::shared_ptr<const StudyResult> first_;
  std::vector<HeadlineSpread> spread_;
};

}  // namespace ertbench
