#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
#include "bench/record/study_result.h"
#include "forward/data/dataset_file.h"

namespace ertbench {

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

}  // namespace ertbench
