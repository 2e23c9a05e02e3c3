#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/contacts/contact_settings.h"
#include "bench/contacts/frame_reading.h"
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
  /// [frames], where the experiment keeps them; else empty.
  std::vector<FrameReading> readings;
};

/// `{"schema", "key", "fit_s", "fit_report": {"status", "message"}, "rows", "frames": {dataset:
/// {metric: [values], "status", "reasons", "iterations", "gap"}}, "figure_images": [[S/m]]}`; where
/// sizes are chosen on it, the validation set is the last of the datasets. Where the experiment
/// keeps contacts, a dataset has its "readings" (frame_reading_record.h) too.
struct AccuracyRecord {
  std::vector<ScoredSet> sets;  ///< of each test set; the rows' statuses are the fit report's
  std::optional<ScoredSet> validation;
  Images figure_images;  ///< [figure scenes, pixels] S/m
};

/// What there is in a record besides what every one has.
struct AccuracyContent {
  bool validation = false;         ///< the validation set is scored as well
  std::vector<int> figure_scenes;  ///< whose images are kept
  ContactSettings contacts;        ///< by which contacts are read and scored
  bool keep_contacts = false;      ///< what was read out of each image is kept
  bool keep_explained = false;     ///< and what each image explains of its voltages
};

/// What determines the record: the solver, the test sets and the content.
std::string accuracy_key(const FitRecipe& recipe, std::span<const DatasetSpec> tests,
                         const AccuracyContent& content);

/// Throws an exception of any kind where the JSON is not such a record. `source` names the file.
AccuracyRecord accuracy_record_from_json(const nlohmann::json& record, bool validation, int pixels,
                                         const std::string& source);

}  // namespace ertbench
