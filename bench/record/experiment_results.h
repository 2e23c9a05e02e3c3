#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/contacts/frame_reading.h"
#include "bench/record/builds_text.h"
#include "bench/record/date_range.h"
#include "bench/record/fidelity_row.h"
#include "bench/record/ladder_record.h"
#include "bench/record/result_row.h"
#include "bench/record/study_result.h"
#include "core/arrays.h"

namespace ertbench {

/// What one label's trials scored on one test set: [seeds][frames].
using FramesOfSeeds = std::vector<std::vector<FrameMetrics>>;

/// The trials of the labels on one test set.
struct ScoredLabels {
  std::string dataset;
  std::vector<std::string> labels;  ///< in the order of the table
  std::vector<FramesOfSeeds> frames;
};

/// Where one training run of a label left its log.
struct TrainingSource {
  std::string stem;           ///< "dd-ert.seed2"
  std::string title;          ///< "seed 2"; empty without seeds
  std::filesystem::path log;  ///< may not exist: not every solver is trained
  JsonValue parameters;       ///< in which "training": {"best_epoch"} may stand
};

/// What fitting and scoring a label's trials, one or one for each seed, came to.
struct LabelOutcome {
  /// The first that was scored; null where none was. It stands for the others where each of them
  /// would take long and tell the same: it is timed and climbs the ladders.
  const SolverEntry* scored = nullptr;
  std::string failure;  ///< of the first trial, where none was scored: "crashed: Aborted; see ..."
};

/// What became of the comparison of the sheet's models on one dataset.
struct FidelityOutcome {
  std::string dataset;
  std::vector<FidelityRow> rows;  ///< none where it failed
  std::string failure;
};

/// All that the results of an experiment are made of. The stages fill it one after another.
struct ExperimentResults {
  std::vector<ResultRow> rows;  ///< truth and no-contact of each test set, then solvers
  /// What each frame scored, of every trial of the labels that were scored: a set's labels stand in
  /// the order of the rows.
  std::vector<ScoredLabels> frames;
  std::map<std::string, Images> images;  ///< by label: [figure scenes, pixels] S/m
  /// By label and test set: [seeds that were scored][frames], where the experiment keeps contacts.
  std::map<std::string, std::map<std::string, std::vector<std::vector<FrameReading>>>> readings;
  /// By label, of the solvers that were fitted.
  std::map<std::string, std::vector<TrainingSource>> training;
  std::map<std::string, LabelOutcome> labels;
  std::vector<LadderOutcome> ladders;  ///< of each label, where the experiment has ladders
  std::vector<FidelityOutcome> fidelity;
  std::vector<StudyOutcome> studies;
  Builds builds;
  std::string command;  ///< makes them again; empty: that of all of the file
  DateRange measured;   ///< when the records were made
  int jobs = 1;
  int failures = 0;  ///< jobs that failed, all rounds of one counted as one
};

}  // namespace ertbench
