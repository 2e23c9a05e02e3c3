#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/run/stage.h"

namespace ertbench {

/// Number of scenes that are timed together.
inline constexpr int fidelity_block = 16;  // two of the condensation's eight lanes

/// Results of one model of the sheet on some scenes of one dataset.
struct FidelityRow {
  std::string dataset;
  std::string scenes;   ///< "smooth", "other" or "all"
  std::string model;    ///< "auto", or the grid's side
  int count = 0;        ///< scenes with contact; every model is exact on the others
  double time_us = 0;   ///< median time of a scene on one thread, rasterising included
  double time_low = 0;  ///< 5 and 95 % quantiles over the blocks
  double time_high = 0;
  double error_median = 0;  ///< of the voltage changes, 2-norm, in units of the frame's noise
  double error_p95 = 0;
  double error_max = 0;
  int kept = 0;  ///< scenes whose error is within the dataset's bound
  double bound = 0.25;
  // "auto" only:
  int promised = 0;        ///< scenes whose estimate is within the bound
  int promised_kept = 0;   ///< scenes of `promised` whose error is within the bound as well
  double tightness = 0;    ///< median of estimate over error
  std::vector<int> sizes;  ///< scenes by points of the border equation, see fidelity_sizes
};

/// Upper ends of the classes of `sizes`; the last class has none.
inline constexpr int fidelity_sizes[] = {16, 32, 64, 128, 256, 512};

/// Comparison of the models of the sheet on one dataset.
struct FidelityOutcome {
  std::string dataset;
  std::vector<FidelityRow> rows;  ///< empty if it failed
  std::string failure;
};
using FidelityOutcomes = std::vector<FidelityOutcome>;

/// One scene computed by one model of the sheet.
struct ModelledScene {
  bool smooth = true;   ///< only whole discs and ellipses that do not touch
  double time_us = 0;   ///< its share of the time of its block
  double error = 0;     ///< 2-norm of the voltage changes' error, in units of the frame's noise
  double estimate = 0;  ///< estimate of that error by "auto"; 0 for grids
  int points = 0;       ///< points of the border equation; 0 for grids
};

/// Measurements on the scenes of one dataset: `{"schema", "key", "models": {"auto" or a grid's
/// side: {"smooth", "time_us", "error", "estimate", "points": [scenes]}}}`.
struct FidelityRecord {
  std::map<std::string, std::vector<ModelledScene>> models;
};

/// Hash of everything that determines the record: the dataset with its sensor, the number of scenes
/// and the machine's processor.
std::string fidelity_key(const DatasetSpec& dataset, int scenes);

/// The JSON lacks the key.
nlohmann::json to_json(const FidelityRecord& record);
/// Throws some std::exception if the JSON is not such a record.
FidelityRecord fidelity_record_from_json(const nlohmann::json& record);

/// The rows of the table: smooth scenes, others and all; only all if there is one kind.
std::vector<FidelityRow> fidelity_rows(const DatasetSpec& dataset, const FidelityRecord& record);

/// Computes the first `scenes` scenes of the dataset with "grid": "auto" and with the grids of 24,
/// 48, 96 and 192, in turn, block by block, on one thread. Errors are against the border integral
/// equation at a thousandth of the bound. Scenes without contact are left out, as every model is
/// exact there. `progress` gets the numbers of scenes done and to do.
FidelityRecord measure_fidelity(
    const DatasetSpec& dataset, int scenes,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress);

/// Compares the models of the sheet on an experiment's scenes (measure_fidelity), `scenes` of each
/// dataset. It needs no solver: every dataset is a job. It writes its own tables and chart.
std::unique_ptr<Stage> fidelity_stage(int scenes);

/// Writes fidelity.csv, fidelity.md, fidelity.svg and .png with provenance into the folder and
/// prints the table. Datasets that failed are named below it.
void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const Builds& builds, const std::filesystem::path& folder);

}  // namespace ertbench
