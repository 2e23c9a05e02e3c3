#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
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

/// Writes `folder`/`name`.md, and `rows` for programs: `folder`/`name`.csv.
void write_study_tables(const Table& table, const TableSection& rows,
                        const std::filesystem::path& folder, const std::string& name);

/// Three cells for programs: the value and the ends of its interval, empty where there is none.
std::vector<Cell> exact_cells(const std::optional<Estimate>& estimate);
/// The titles of three such columns: "mean_mm", "mean_mm_low", "mean_mm_high".
std::vector<Column> exact_columns(const std::string& name);

/// What a study is made from.
struct StudyInput {
  const StudySpec& spec;
  const Experiment& experiment;
  const ExperimentResults& results;  ///< with rows, readings and latencies
  const Cache& cache;
  /// Which of the trainings of each solver is judged, of those that were scored; the first one
  /// stands for solvers that are not trained.
  std::size_t training = 0;

  /// Of all solvers that have that training, in the order of the experiment; of the first one also
  /// those that failed.
  std::vector<std::string> labels() const;
  /// Of the solver that was trained most often.
  std::size_t trainings() const;
  const DatasetSpec& set_spec(const std::string& set) const;
  DatasetFile open(const std::string& set) const;
  /// What the label's solver found in each frame of the set, with the training that is judged; null
  /// where it did not get that far.
  const std::vector<FrameReading>* readings(const std::string& label, const std::string& set) const;
  /// Why there are none: "crashed: ...".
  std::string failure(const std::string& label) const;
  /// Median and 99th percentile of the time from voltages to image, s; nothing where not measured.
  struct Latency {
    double p50_s;
    double p99_s;
  };
  std::optional<Latency> latency(const std::string& label) const;
  /// "falling" or "rising": stands in every table.
  std::string law() const;
};

/// The result of any study: of the first training of each solver, with what the others make of its
/// headlines (StudyTrainings). Throws what reading its datasets throws.
std::shared_ptr<const StudyResult> make_study(const StudyInput& input);

/// One headline of a solver that was trained more than once.
struct HeadlineSpread {
  std::string label;
  std::string what;
  int decimals = 2;
  std::vector<std::optional<double>> values;  ///< [trainings]

  std::optional<double> mean() const;       ///< of the trainings that have a value
  std::optional<double> deviation() const;  ///< sample standard deviation; of two values at least
};

/// `of_trainings` [trainings] are the headlines of each; of the later ones those of the solvers
/// that were trained so often, which are the ones that have a spread.
std::vector<HeadlineSpread> spread_of(std::span<const std::vector<Headline>> of_trainings);

/// A study of the first training of each solver, and what the other trainings make of its
/// headlines: what is the method's, and what one training's luck.
class StudyTrainings : public StudyResult {
 public:
  StudyTrainings(std::string name, std::shared_ptr<const StudyResult> first,
                 std::vector<HeadlineSpread> spread)
      : name_(std::move(name)), first_(std::move(first)), spread_(std::move(spread)) {}

  /// The first training's, with `"trainings": [{"solver", "what", "values", "mean", "deviation"}]`.
  nlohmann::json summary() const override;
  std::vector<Headline> headlines() const override { return first_->headlines(); }
  /// The first training's, then a section on the others, also as NAME_trainings.md and .csv.
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string name_;
  std::shared_ptr<const StudyResult> first_;
  std::vector<HeadlineSpread> spread_;
};

/// The studies of an experiment (bench/studies), made from what the stages before it left: the
/// frames' readings and the latencies. It has no jobs of its own.
class StudyStage : public Stage {
 public:
  std::string name() const override;
  std::string noun() const override;
  std::vector<Job> jobs(const Experiment& experiment) const override;
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override;
  std::string key(const Experiment& experiment, const Job& job) const override;
  nlohmann::json run(const Job& job, const JobContext& context) const override;
  void check(const Experiment& experiment, const nlohmann::json& record) const override;
  void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
               ExperimentResults& results) const override;
  std::vector<ReportSection> report(const Experiment& experiment, const ExperimentResults& results,
                                    const std::filesystem::path& folder) const override;
};

}  // namespace ertbench
