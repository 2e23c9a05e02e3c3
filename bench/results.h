#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/cache.h"
#include "bench/experiment.h"
#include "bench/ladder_results.h"
#include "bench/result_row.h"
#include "bench/training_results.h"
#include "forward/arrays.h"

namespace ertbench {

/// All that the results of an experiment are made of.
struct ExperimentResults {
  std::vector<ResultRow> rows;           ///< truth and no-contact of each test set, then solvers
  std::map<std::string, Images> images;  ///< by label: [figure scenes, pixels] S/m
  /// By label, of the solvers that were fitted.
  std::map<std::string, std::vector<TrainingSource>> training;
  std::vector<LadderOutcome> ladders;  ///< of each label, where the experiment has ladders
  int jobs = 1;
};

/// The rows that need no solver: the true images themselves, scored like any other, and the image
/// of an untouched sheet.
std::vector<ResultRow> reference_rows(const Experiment& experiment, const Cache& cache);

/// summary.json, table.md, table.csv, table.tex, the figure of reconstructions, the charts that the
/// experiment asks for, those of the training and of the ladders, and report.html of all this; each
/// file is written aside and renamed.
void write_results(const Experiment& experiment, const Cache& cache,
                   const ExperimentResults& results, const std::filesystem::path& folder);

/// A short table for the terminal.
std::string console_table(const std::vector<ResultRow>& rows);

}  // namespace ertbench
