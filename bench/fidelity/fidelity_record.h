#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "forward/data/dataset_spec.h"

namespace ertbench {

/// Scenes whose time is taken as one.
inline constexpr int fidelity_block = 16;  // two of the condensation's eight lanes

/// One model of the sheet on some scenes of one distribution.
struct FidelityRow {
  std::string dataset;
  std::string scenes;   ///< "smooth", "other" or "all"
  std::string model;    ///< "auto", or the grid's side
  int count = 0;        ///< scenes, blank ones left out: every model is exact there
  double time_us = 0;   ///< median time of a scene on one thread, rasterising included where needed
  double time_low = 0;  ///< 5 and 95 % of the blocks of scenes that are timed as one
  double time_high = 0;
  double error_median = 0;  ///< of the voltage changes, 2-norm, in units of the frame's noise
  double error_p95 = 0;
  double error_max = 0;
  int kept = 0;  ///< scenes whose error is within the dataset's bound
  double bound = 0.25;
  // Of "auto" alone.
  int promised = 0;        ///< scenes whose estimate is within the bound
  int promised_kept = 0;   ///< those of `promised` whose error is within the bound as well
  double tightness = 0;    ///< median of estimate over error
  std::vector<int> sizes;  ///< scenes by points of the border equation, see fidelity_sizes
};

/// Upper ends of the classes of `sizes`; the last class has none.
inline constexpr int fidelity_sizes[] = {16, 32, 64, 128, 256, 512};

/// Outcome of comparing the models of the sheet on one dataset.
struct FidelityOutcome {
  std::string dataset;
  std::vector<FidelityRow> rows;  ///< none where it failed
  std::string failure;
};
using FidelityOutcomes = std::vector<FidelityOutcome>;

/// One scene as one model of the sheet computes it.
struct ModelledScene {
  bool smooth = true;   ///< whole discs and ellipses apart from each other, nothing else
  double time_us = 0;   ///< its share of the time that its block of scenes took
  double error = 0;     ///< of the voltage changes, 2-norm, in units of the frame's noise
  double estimate = 0;  ///< of that error, by "auto" itself; of the grids 0
  int points = 0;       ///< of the border equation; of the grids 0
};

/// What was measured on the scenes of one dataset: `{"schema", "key", "models": {"auto" or a grid's
/// side: {"smooth", "time_us", "error", "estimate", "points": [scenes]}}}`.
struct FidelityRecord {
  std::map<std::string, std::vector<ModelledScene>> models;
};

/// Scenes of the dataset that are looked at where `scenes` are asked for; blank ones among them.
int fidelity_scenes(const DatasetSpec& dataset, int scenes);

/// What determines the record: the dataset with its sensor, the number of scenes, and the machine's
/// processor.
std::string fidelity_key(const DatasetSpec& dataset, int scenes);

/// Without the key.
nlohmann::json to_json(const FidelityRecord& record);
/// Throws an exception of any kind where the JSON is not such a record.
FidelityRecord fidelity_record_from_json(const nlohmann::json& record);

/// The rows of the table: of the smooth scenes, of the others, and of all; of all alone where there
/// is but one kind.
std::vector<FidelityRow> fidelity_rows(const DatasetSpec& dataset, const FidelityRecord& record);

}  // namespace ertbench
