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
#include "frames/calibration.h"

namespace ertbench {

/// A published result to stand beside the row of the same label.
struct PublishedRow {
  std::string label;
  PerMetric<std::optional<double>> values;
};

/// "published" of an experiment file.
struct PublishedTable {
  std::string source;                 ///< "Zheng et al., Table C1"
  std::vector<PublishedRow> rows;     ///< lengths in half sides, whatever the file has them in
  std::vector<std::string> datasets;  ///< the test sets it is compared with; empty: all
};

/// "right_sizing" of an experiment: of each family of settings the smallest that is good enough on
/// the validation set. A family's settings are listed from the smallest to the largest.
struct RightSizing {
  double margin = 0.05;  ///< how far an error may lie above the family's least, as a part of that
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

/// How often `ertbench check` trains each network, as a single training says little of the next.
struct CheckSettings {
  /// Trainings in a check, 0: as many as the solver's entry has seeds. Its means are judged.
  int seeds = 0;
  /// Trainings behind the baseline's interval, 0: as many as `check --update` takes by itself.
  int baseline_seeds = 0;
};

/// An experiment file: what is generated, what is fitted, what is measured.
struct Experiment {
  std::string name;  ///< the file's name without its ending; the result folder's name
  std::filesystem::path file;
  std::string source;                        ///< the file in messages, with those that it extends
  std::vector<std::filesystem::path> files;  ///< the file and those that it extends
  std::vector<std::string> overrides;        ///< of its values, as given: apply_overrides
  std::string title;
  std::string question;  ///< what the experiment is for, in a sentence or two
  Sensor sensor;
  std::optional<DatasetSpec> training;         ///< "train"
  std::optional<DatasetSpec> validation;       ///< "validation"
  std::vector<DatasetSpec> tests;              ///< every other name, at least one
  std::vector<SolverEntry> solvers;            ///< every seed and every point of a sweep on its own
  std::vector<std::filesystem::path> plugins;  ///< libraries of the user's own solvers
  TimingSettings timing;
  ContactSettings contacts;
  /// Whether the records of accuracy hold what was read out of each image (FrameReading).
  bool keep_contacts = false;
  /// Whether what each image explains of its voltages is kept, too: for the study consistency.
  bool keep_explained = false;
  CheckSettings check;
  double time_limit_s = 3600;  ///< for one trial
  /// For one trial's processes together; nothing: 9/10 of the machine's, shared out among the
  /// trials that run at a time.
  std::optional<double> memory_limit_mb;
  std::vector<int> figure_scenes;  ///< of the first test set
  PublishedTable published;
  std::vector<std::shared_ptr<const Chart>> charts;
  std::vector<StudySpec> studies;
  std::optional<RightSizing> right_sizing;
  std::optional<Ladders> ladders;
  std::optional<Folds> folds;

  const DatasetSpec* find_dataset(const std::string& dataset) const;
  std::vector<const DatasetSpec*> datasets() const;  ///< all of them
  /// The entries of each label, which make one row: one entry, or one for each seed.
  std::vector<std::span<const SolverEntry>> rows() const;
};

/// Whether solvers are made to have their parameters checked: those of plugins in child processes.
enum class SolverCheck { all, none };

/// Reads and checks an experiment file (read_experiment_json) whole: unknown keys, types, ranges,
/// solvers' parameters. Throws InputError naming file, JSON path and remedy. Solvers of a plugin
/// that is absent are left to their trials, and those that took their process down are marked
/// (SolverEntry::failure), so that the other rows come out. `charts` are the types of charts that
/// there are (chart_types()); where the list is empty the charts are left unread, for processes
/// that draw none. `overrides`: values from the command line (apply_overrides).
Experiment read_experiment(const std::filesystem::path& file, SolverRegistry& registry,
                           const ChartTypes& charts, SolverCheck check = SolverCheck::all,
                           const std::vector<std::string>& overrides = {});

/// The schema of "timing", "contacts", "check" and the limits of a trial.
nlohmann::ordered_json experiment_settings_schema();

/// Reads "calibration", the name of a file beside the experiment's: gives the sensor the background
/// that was found, or the whole sensor where the experiment names none. Nothing where there is no
/// such key. Throws InputError where the file is of another sensor.
std::optional<Calibration> read_calibration_of(JsonObject& root, Experiment& experiment);

/// Adds, where it has none, a validation set with noise of the level that was measured.
void complete_with(const Calibration& calibration, Experiment& experiment);

}  // namespace ertbench
