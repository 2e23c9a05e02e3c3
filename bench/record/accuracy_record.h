#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/fit_recipe.h"
#include "bench/record/result_row.h"
#include "bench/score/metrics.h"
#include "core/arrays.h"
#include "solvers/solver.h"

namespace ertbench {

/// Raised whenever the same images would score otherwise; part of the keys of accuracy and timing.
/// A metric more needs no other version: the key of what was scored holds the metrics' names.
inline constexpr int metrics_version = 1;

/// What one trial did on one test set.
struct ScoredSet {
  ResultRow row;
  std::vector<FrameMetrics> frames;
  std::vector<FrameStatus> statuses;  ///< [frames]
};

/// `{"schema", "key", "fit_s", "fit_report": {"status", "message"}, "rows", "frames": {dataset:
/// {metric: [values], "status", "reasons", "iterations", "gap"}}, "figure_images": [[S/m]]}`; where
/// sizes are chosen on it, the validation set is the last of the datasets.
struct AccuracyRecord {
  std::vector<ScoredSet> sets;  ///< of each test set; the rows' statuses are the fit report's
  std::optional<ScoredSet> validation;
  Images figure_images;  ///< [figure scenes, pixels] S/m
};

/// What determines the record: the solver, the test sets, whether the validation set is scored as
/// well, and the scenes whose images are kept.
std::string accuracy_key(const FitRecipe& recipe, std::span<const DatasetSpec> tests,
                         bool validation, const std::vector<int>& figure_scenes);

/// Throws an exception of any kind where the JSON is not such a record. `source` names the file.
AccuracyRecord accuracy_record_from_json(const nlohmann::json& record, bool validation, int pixels,
                                         const std::string& source);

}  // namespace ertbench
