#pragma once

#include "bench/run/stage.h"

namespace ertbench {

/// Holds the models of the sheet against each other on an experiment's scenes, see
/// measure_fidelity. It needs no solver: every dataset is a job. Its results are tables and a chart
/// of their own.
class FidelityStage : public Stage {
 public:
  explicit FidelityStage(int scenes) : scenes_(scenes) {}  ///< of each dataset

  std::string name() const override;
  std::string noun() const override;
  bool wants_machine_alone() const override { return true; }
  bool reads_datasets() const override { return false; }  // it draws its scenes itself
  double time_limit_s(const Experiment& experiment) const override;
  std::vector<std::string> options() const override;
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

 private:
  int scenes_;
};

}  // namespace ertbench
