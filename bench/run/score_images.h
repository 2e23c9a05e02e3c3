#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/score/metric_summary.h"

namespace ertbench {

/// Images that were made elsewhere, and the truth.
struct ScoreOptions {
  std::filesystem::path images;
  std::filesystem::path truth;
  std::filesystem::path sensor;  ///< empty: what the truth's file says, then the images', then d2s
  std::string dataset;           ///< of the images; empty: /conductivity_change, or /conductivity
};

struct ImageScores {
  int frames = 0;
  int undefined_frames = 0;  ///< without a usable image
  PerMetric<MetricSummary> metrics;
  /// Where the true contacts come from: "contacts of the file", "regions of the true images".
  std::string contacts;
};

/// Scores every image by all metrics. `images`: HDF5 with the change of the conductivity
/// /conductivity_change, or the conductivity itself /conductivity, [N, rows, columns] or [N,
/// pixels] S/m, and, where it is there, /status [N] (2: undefined). `truth`: a dataset file, or
/// HDF5 with /conductivity [N, rows, columns] S/m alone: its contacts are then the regions that the
/// default rule reads out of the true images. Throws InputError where the two do not fit together.
ImageScores score_images(const ScoreOptions& options);

/// `{"schema", "frames", "undefined_frames", "contacts", "metrics": {NAME: {"mean", "ci95",
/// "median", "count", "undefined"}}}`; null where there is no value.
nlohmann::json to_json(const ImageScores& scores);

}  // namespace ertbench
