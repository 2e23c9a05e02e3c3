#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment_json.h"
#include "bench/ktc2023/ktc_files.h"
#include "bench/ktc2023/ktc_methods.h"

namespace ertbench {

inline constexpr int ktc_levels = 7;

/// One target at one level.
struct KtcOutcome {
  std::string target;
  int level = 1;
  std::optional<ClassMap> truth;
  ClassMap classes;
  std::optional<double> score;
  double time_s = 0;
};

/// One method with one way to segment its images.
struct KtcRow {
  std::string label;
  std::vector<KtcOutcome> outcomes;

  /// Three times the mean score of the targets of a level: of three targets their sum.
  std::optional<double> score_of(int level) const;
  /// Sum over all levels; none where a level has no score.
  std::optional<double> sum() const;
  double mean_score() const;  ///< of all outcomes with a truth, 0 if there are none
  double median_time_s() const;
};

struct KtcResults {
  std::string title;
  std::string question;
  std::string command;
  std::map<std::string, KtcCalibration> calibrations;  ///< by the reference's file
  std::vector<KtcRow> rows;
  std::vector<KtcRow> simulated;  ///< of simulated targets, if they were asked for
  /// Published scores, by level or a sum alone.
  std::vector<std::pair<std::string, std::vector<double>>> official;
  bool simulated_levels = false;  ///< whole targets stood for levels
};

/// Reads the experiment and runs it on one thread. Throws InputError naming file and place.
KtcResults ktc_results(const ExperimentJson& json);

/// Writes table.md, targets.csv, scores.json and the figure of all targets, and prints the table.
/// Returns how many figures could not be drawn.
std::size_t report_ktc(const KtcResults& results, const std::filesystem::path& folder);

/// What `ertbench run` does with such a file.
std::size_t run_ktc(const ExperimentJson& json, const std::filesystem::path& folder,
                    const std::string& command);

}  // namespace ertbench
