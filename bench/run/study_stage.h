#pragma once

#include "bench/run/stage.h"

namespace ertbench {

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
