#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment_charts.h"
#include "bench/experiment/ladder_spec.h"
#include "bench/experiment/solver_entry.h"
#include "bench/experiment/study_spec.h"
#include "bench/score/image_contacts.h"
#include "bench/score/metrics.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// A published result, shown beside the row of the same label.
struct PublishedRow {
  std::string label;
  PerMetric<std::optional<double>> values;
};

/// "published" of an experiment file.
struct PublishedTable {
  std::string source;                 ///< "Zheng et al., Table C1"
  std::vector<PublishedRow> rows;     ///< lengths in half sides, whatever the unit of the file
  std::vector<std::string> datasets;  ///< the test sets that it is compared with; empty: all
};

/// "right_sizing" of an experiment: chooses in each family of settings the smallest that is good
/// enough on the validation set. The settings of a family are listed from smallest to largest.
struct RightSizing {
  double margin = 0.05;  ///< largest excess over the family's least error, relative to it
  Metric metric = Metric::relative_error;
};

class SolverRegistry;

/// How latency and throughput are measured.
struct TimingSettings {
  bool enabled = true;
  int frames = 1000;  ///< timed one by one; at least 662, so that the 99th percentile has meaning
  int warm_up = 20;   ///< frames before the clock counts, in each round
  int batch = 256;    ///< frames in a call when throughput is measured
  int rounds = 5;     ///< the frames are shared out among them; solvers take turns
};

/// How often `ertbench check` trains each network: a single training predicts the next one poorly.
struct CheckSettings {
  /// Trainings in a check, whose means are judged; 0: as many as the entry has seeds.
  int seeds = 0;
  /// Trainings for the interval of a baseline; 0: the default of `check --update`.
  int baseline_seeds = 0;
};

/// The content of an experiment file: datasets, solvers, and what is measured.
struct Experiment {
  std::string name;  ///< the file's name without its ending; the result folder's name
  std::filesystem::path file;
  std::string source;                        ///< name in messages, with the files that it extends
  std::vector<std::filesystem::path> files;  ///< the file and those that it extends
  std::vector<std::string> overrides;        ///< from the command line (apply_overrides)
  std::string title;
  std::string question;         ///< its purpose, in a sentence or two
  std::string made_by = "run";  ///< the command whose results `publish` publishes
  Sensor sensor;
  std::optional<DatasetSpec> training;         ///< "train"
  std::optional<DatasetSpec> validation;       ///< "validation"
  std::vector<DatasetSpec> tests;              ///< every other name, at least one
  std::vector<SolverEntry> solvers;            ///< one for each seed and each point of a sweep
  std::vector<std::filesystem::path> plugins;  ///< libraries of the user's own solvers
  TimingSettings timing;
  ContactSettings contacts;
  /// Whether records of accuracy keep the contacts read from each image (FrameReading).
  bool keep_contacts = false;
  /// Whether they also keep how much of its voltages each image explains, for the study
  /// consistency.
  bool keep_explained = false;
  CheckSettings check;
  double time_limit_s = 3600;  ///< for one trial
  /// For all processes of one trial. Default: 9/10 of the machine's memory, divided among the
  /// trials that run at the same time.
  std::optional<double> memory_limit_mb;
  std::vector<int> figure_scenes;  ///< of the first test set
  PublishedTable published;
  std::vector<std::shared_ptr<const Chart>> charts;
  std::vector<StudySpec> studies;
  std::optional<RightSizing> right_sizing;
  std::optional<Ladders> ladders;
  std::optional<Folds> folds;
  /// How the results are shown: "charts", "published" and "right_sizing" as the file has them, for
  /// summary.json.
  JsonValue presentation;

  const DatasetSpec* find_dataset(const std::string& dataset) const;
  std::vector<const DatasetSpec*> datasets() const;  ///< all of them
  /// The entries of each row, which share a label: one entry, or one for each seed.
  std::vector<std::span<const SolverEntry>> rows() const;
};

/// Whether reading constructs the solvers to check their parameters; those of plugins are
/// constructed in child processes.
enum class SolverCheck { all, none };

/// Reads and checks a whole experiment file (read_experiment_json): unknown keys, types, ranges,
/// solvers' parameters. Throws InputError naming file, JSON path and remedy. Solvers of an absent
/// plugin fail in their trials; solvers that end their process are marked (SolverEntry::failure),
/// so that the other rows are computed. `charts`: the known types (chart_types()), or none for
/// processes that draw no charts and leave them unread. `overrides`: values from the command line
/// (apply_overrides).
Experiment read_experiment(const std::filesystem::path& file, SolverRegistry& registry,
                           const ChartTypes& charts, SolverCheck check = SolverCheck::all,
                           const std::vector<std::string>& overrides = {});

/// Reads "right_sizing", "published" and "charts" of a file, or of what a summary.json keeps of it
/// (Experiment::presentation), and keeps them. Datasets, solvers and timing must have been read.
/// Throws InputError.
void read_presentation(JsonObject& root, Experiment& experiment, const ChartTypes& charts,
                       SolverRegistry& registry);

/// The schema of "timing", "contacts", "check" and the limits of a trial.
nlohmann::ordered_json experiment_settings_schema();

}  // namespace ertbench
