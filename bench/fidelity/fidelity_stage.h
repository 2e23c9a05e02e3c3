#pragma once

#include <cstdint>
#include <functional>

#include "bench/fidelity/fidelity_record.h"
#include "bench/run/stage.h"

namespace ertbench {

/// Computes the first `scenes` scenes of the dataset with "grid": "auto" and with the grids of 24,
/// 48, 96 and 192, in turn, block by block, on one thread. Errors are against the border integral
/// equation at a thousandth of the bound. Scenes without contact are left out, as every model is
/// exact there. `progress` gets the numbers of scenes done and to do.
FidelityRecord measure_fidelity(
    const DatasetSpec& dataset, int scenes,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress);

/// Compares the models of the sheet on an experiment's scenes (measure_fidelity). It needs no
/// solver: every dataset is a job. It writes its own tables and chart.
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
