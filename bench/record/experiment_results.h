#pragma once

#include <any>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <typeindex>
#include <vector>

#include "bench/record/result_row.h"
#include "bench/score/image_contacts.h"
#include "core/arrays.h"

namespace ertbench {

struct SolverEntry;
struct Study;  // bench/studies/study.h

/// One of the few numbers by which a study's solvers are told apart: what is compared where a
/// solver was trained more than once.
struct Headline {
  std::string label;            ///< of the solver
  std::string what;             ///< with condition and unit: "disc_10N: median, thresholded (mm)"
  int decimals = 2;             ///< that it is shown with
  std::optional<double> value;  ///< nothing where it is undefined
};

/// The result of one study (StudySpec).
struct StudyOutcome {
  std::string name;
  std::string type;
  JsonValue summary;  ///< all numbers, for summary.json; each with its interval where it has one
  std::shared_ptr<const Study> study;
};

/// Scores of one label's trials on one test set: [seeds][frames].
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

/// Outcome of fitting and scoring the trials of a label, one for each seed.
struct LabelOutcome {
  /// The first that was scored; null where none was. It stands for the others where each of them
  /// would take long and tell the same: it is timed and climbs the ladders.
  const SolverEntry* scored = nullptr;
  std::string failure;  ///< of the first trial, where none was scored: "crashed: Aborted; see ..."
};

/// Findings of the features that stand above this room, one value of each type. A feature's stage
/// collects into its own type and reports from it; nothing else needs to know it.
class FeatureFindings {
 public:
  /// The value of type T, made empty where there is none yet.
  template <typename T>
  T& of() {
    std::any& value = values_[typeid(T)];
    if (!value.has_value()) value = T();
    return *std::any_cast<T>(&value);
  }
  /// A copy of the value of type T; an empty one where nothing was collected.
  template <typename T>
  T found() const {
    const auto value = values_.find(typeid(T));
    return value == values_.end() ? T() : std::any_cast<T>(value->second);
  }

 private:
  std::map<std::type_index, std::any> values_;
};

/// All that the results of an experiment are made of. The stages fill it one after another.
struct ExperimentResults {
  std::vector<ResultRow> rows;  ///< truth and no-contact of each test set, then solvers
  /// Scores of each frame in every trial of the scored labels: a set's labels stand in
  /// the order of the rows.
  std::vector<ScoredLabels> frames;
  std::map<std::string, Images> images;  ///< by label: [figure scenes, pixels] S/m
  /// By label and test set: [seeds that were scored][frames], where the experiment keeps contacts.
  std::map<std::string, std::map<std::string, std::vector<std::vector<FrameReading>>>> readings;
  /// By label, of the solvers that were fitted.
  std::map<std::string, std::vector<TrainingSource>> training;
  std::map<std::string, LabelOutcome> labels;
  FeatureFindings findings;  ///< of ladders and fidelity
  std::vector<StudyOutcome> studies;
  Builds builds;
  std::string command;  ///< makes them again; empty: that of all of the file
  DateRange measured;   ///< when the records were made
  int jobs = 1;
  int failures = 0;                    ///< jobs that failed, all rounds of one counted as one
  std::shared_ptr<const void> folder;  ///< keeps other runs out of it
};

}  // namespace ertbench
