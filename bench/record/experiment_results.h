#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/record/ladder_record.h"
#include "bench/record/result_row.h"
#include "core/arrays.h"

namespace ertbench {

/// Where one training run of a label left its log.
struct TrainingSource {
  std::string stem;           ///< "dd-ert.seed2"
  std::string title;          ///< "seed 2"; empty without seeds
  std::filesystem::path log;  ///< may not exist: not every solver is trained
  JsonValue parameters;       ///< in which "training": {"best_epoch"} may stand
};

/// All that the results of an experiment are made of.
struct ExperimentResults {
  std::vector<ResultRow> rows;           ///< truth and no-contact of each test set, then solvers
  std::map<std::string, Images> images;  ///< by label: [figure scenes, pixels] S/m
  /// By label, of the solvers that were fitted.
  std::map<std::string, std::vector<TrainingSource>> training;
  std::vector<LadderOutcome> ladders;  ///< of each label, where the experiment has ladders
  int jobs = 1;
  int failures = 0;  ///< trials that failed
};

}  // namespace ertbench
