#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
#include "bench/report/report.h"
#include "bench/run/stage.h"
#include "bench/studies/error_statistics.h"
#include "bench/table/table.h"
#include "forward/data/dataset_file.h"
#include "forward/data/faults.h"

namespace ertbench {

std::string force_text(const std::pair<double, double>& force_N);  ///< "5 N", "1 to 10 N"
std::string noise_text(const Noise& noise);                        ///< "50 dB absolute", "no noise"
/// An experiment's title for the heading of a figure, which names the law among its conditions:
/// "Collision" of "Collision, rising law".
std::string without_law(const std::string& title);

/// A figure of a study.
struct StudyFigure {
  std::string part;   ///< its file's name behind that of the study: "_map_disc"; may be empty
  std::string title;  ///< in the report, before the caption
  std::string caption;
  std::string heading;  ///< on the picture, behind the experiment's title: ", falling law"
  /// Draws `stem`.svg and .png.
  std::function<void(const std::string& heading, const std::filesystem::path& stem)> draw;
};

/// A section of the report and the files beside it.
struct StudySection {
  std::string part;      ///< its files' name behind that of the study; may be empty
  std::string subject;   ///< behind the experiment's title in the Markdown file; may be empty
  ReportSection report;  ///< without its figures
  std::vector<StudyFigure> figures;
  /// CSV files, each with its name behind that of the section; the first is usually "".
  std::vector<std::pair<std::string, TableSection>> data;
};

/// The result of any study. Each study is a function that returns one.
struct Study {
  std::string name;        ///< begins the names of its files
  nlohmann::json numbers;  ///< all of them, for summary.json
  /// The headlines of every solver that did not fail; none of a study whose trainings are not
  /// compared.
  std::vector<Headline> best;
  std::vector<StudySection> sections;

  Study() = default;
  /// With a first section of that title.
  Study(std::string its_name, std::string title, nlohmann::json its_numbers);

  /// Draws the figures and writes NAME.md with the tables of a section and its CSV files beside
  /// them; returns the sections of the report. `title` is the experiment's.
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const;
};

/// A study's input.
struct StudyInput {
  const StudySpec& spec;
  const Experiment& experiment;
  const ExperimentResults& results;  ///< with rows, readings and latencies
  const Cache& cache;
  /// The training of each solver that is judged, of those that were scored; 0 for solvers that are
  /// not trained.
  std::size_t training = 0;

  /// Labels of the solvers that have that training, in the order of the experiment; those of the
  /// first training include solvers that failed.
  std::vector<std::string> labels() const;
  /// Number of trainings of the solver that was trained most often.
  std::size_t trainings() const;
  const DatasetSpec& set_spec(const std::string& set) const;
  DatasetFile open(const std::string& set) const;
  /// Readings of the label's images [frames] in the training that is judged; null where the solver
  /// failed before.
  const std::vector<FrameReading>* readings(const std::string& label, const std::string& set) const;
  /// Why there are none: "crashed: ...".
  std::string failure(const std::string& label) const;
  /// Median time from voltages to image, s; nothing where not measured.
  std::optional<double> latency_s(const std::string& label) const;
  /// "falling" or "rising": stands in every table.
  std::string law() const;
};

/// The study of the first training of each solver. Where a solver was trained more than once,
/// `"trainings": [{"solver", "what", "values", "mean", "deviation"}]` and a section of its own tell
/// how its headlines differ between trainings. Throws what reading its datasets throws.
std::shared_ptr<const Study> make_study(const StudyInput& input);

/// One headline of a solver that was trained more than once.
struct HeadlineSpread {
  std::string label;
  std::string what;
  int decimals = 2;
  std::vector<std::optional<double>> values;  ///< [trainings]
};

/// `of_trainings` [trainings] are the headlines of each; of the later ones those of the solvers
/// that were trained so often, which are the ones that have a spread.
std::vector<HeadlineSpread> spread_of(std::span<const std::vector<Headline>> of_trainings);

/// The studies of an experiment (bench/studies), made from what the stages before it left: the
/// frames' readings and the latencies. It has no jobs of its own.
std::unique_ptr<Stage> study_stage();

}  // namespace ertbench
