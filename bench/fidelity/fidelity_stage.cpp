#include "bench/fidelity/fidelity_stage.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/fidelity/fidelity_record.h"
#include "bench/fidelity/fidelity_report.h"
#include "bench/record/record_file.h"
#include "bench/run/job_runner.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

constexpr int grids[] = {24, 48, 96, 192};
constexpr double reference_share = 1e-3;  ///< of the bound, for the converged solution
constexpr int reference_points = 2500;

bool is_smooth(const std::vector<ContactArc>& arcs) {
  return std::all_of(arcs.begin(), arcs.end(), [](const ContactArc& arc) { return arc.closed; });
}

/// Voltage changes of a block of scenes by one model, [scenes, channels] V.
struct ModelledBlock {
  Frames changes;
  std::vector<BorderModel::Solution> solutions;  ///< of "auto"
};

class Models {
 public:
  explicit Models(const Sensor& sensor) : borders_(sensor) {
    for (const int grid : grids) grids_.emplace(grid, ForwardModel(sensor, grid));
  }

  const BorderModel& borders() const { return borders_; }

  ModelledBlock automatic(const DatasetSpec& spec, const std::vector<Scene>& scenes) const {
    ModelledBlock out;
    out.changes.resize(static_cast<Eigen::Index>(scenes.size()), spec.sensor.channels());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      out.solutions.push_back(borders_.solve(scenes[i], [&](const Eigen::VectorXd& change) {
        return model_error_of(spec.model) * noise(spec, change);
      }));
      out.changes.row(static_cast<Eigen::Index>(i)) = out.solutions.back().change;
    }
    return out;
  }

  ModelledBlock on_grid(int grid, const DatasetSpec& spec, const std::vector<Scene>& scenes) const {
    const ForwardModel& model = grids_.at(grid);
    const PixelGrid pixels = spec.sensor.sheet->pixels(grid);
    Images sheets(static_cast<Eigen::Index>(scenes.size()), pixels.count());
    Eigen::VectorXd ratio(pixels.count());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      rasterise(scenes[i], pixels, Rasterisation::area, ratio);
      sheets.row(static_cast<Eigen::Index>(i)) = spec.sensor.background * ratio.transpose();
    }
    ModelledBlock out;
    out.changes = model.solve(sheets).rowwise() - model.reference_voltages().transpose();
    return out;
  }

  double noise(const DatasetSpec& spec, const Eigen::VectorXd& change) const {
    const Eigen::VectorXd& reference = borders_.reference_voltages();
    return noise_norm(spec.noise, reference, reference + change);
  }

 private:
  BorderModel borders_;
  std::map<int, ForwardModel> grids_;
};

/// Computes one block, of one kind of scenes, with every model in turn.
void measure_block(const Models& models, const DatasetSpec& spec, const std::vector<Scene>& scenes,
                   bool smooth, FidelityRecord& record) {
  std::vector<Eigen::VectorXd> exact;
  for (const Scene& scene : scenes) {
    exact.push_back(models.borders()
                        .solve(
                            scene,
                            [&](const Eigen::VectorXd& change) {
                              return reference_share * model_error_of(spec.model) *
                                     models.noise(spec, change);
                            },
                            reference_points)
                        .change);
  }
  const auto measure = [&](const std::string& name, const auto& compute) {
    const auto start = std::chrono::steady_clock::now();
    const ModelledBlock made = compute();
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const double noise = models.noise(spec, exact[i]);
      ModelledScene outcome;
      outcome.smooth = smooth;
      outcome.time_us = time.count() / static_cast<double>(scenes.size());
      outcome.error =
          (made.changes.row(static_cast<Eigen::Index>(i)).transpose() - exact[i]).norm() / noise;
      if (!made.solutions.empty()) {
        outcome.estimate = made.solutions[i].error / noise;
        outcome.points = made.solutions[i].points;
      }
      record.models[name].push_back(outcome);
    }
  };
  measure("auto", [&] { return models.automatic(spec, scenes); });
  for (const int grid : grids) {
    measure(std::to_string(grid), [&] { return models.on_grid(grid, spec, scenes); });
  }
}

}  // namespace

FidelityRecord measure_fidelity(
    const DatasetSpec& dataset, int scenes,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress) {
  const Models models(dataset.sensor);
  FidelityRecord record;
  std::map<bool, std::vector<Scene>> waiting;  // by smoothness, for a block of their own kind
  const auto measure = [&](bool smooth) {
    measure_block(models, dataset, waiting[smooth], smooth, record);
    waiting[smooth].clear();
  };
  const auto count = static_cast<std::uint64_t>(fidelity_scenes(dataset, scenes));
  for (std::uint64_t i = 0; i < count; ++i) {
    Scene scene = dataset.scene(i);
    const std::vector<ContactArc> arcs = contact_arcs(scene, *dataset.sensor.sheet);
    if (arcs.empty()) continue;
    const bool smooth = is_smooth(arcs);
    waiting[smooth].push_back(std::move(scene));
    if (waiting[smooth].size() == fidelity_block) measure(smooth);
    progress(i + 1, count);
  }
  for (const bool smooth : {true, false}) {
    if (!waiting[smooth].empty()) measure(smooth);
  }
  return record;
}

namespace {

constexpr double scenes_of_one_limit = 500;

const DatasetSpec& dataset_of(const Experiment& experiment, const Job& job) {
  return *experiment.find_dataset(job.subject);
}

}  // namespace

std::string FidelityStage::name() const { return "fidelity"; }

std::string FidelityStage::noun() const { return "dataset"; }

double FidelityStage::time_limit_s(const Experiment& experiment) const {
  // The limit is that of a trial; it grows with the number of scenes asked for.
  return experiment.time_limit_s * std::max(1.0, scenes_ / scenes_of_one_limit);
}

std::vector<std::string> FidelityStage::options() const {
  return {"--scenes=" + std::to_string(scenes_)};
}

std::vector<Job> FidelityStage::jobs(const Experiment& experiment) const {
  std::vector<Job> jobs;
  for (const DatasetSpec* dataset : experiment.datasets()) {
    if (!dataset->measured()) jobs.push_back(job_of(*this, *dataset));
  }
  return jobs;
}

std::vector<Job> FidelityStage::due(const Experiment& experiment, const ExperimentResults&) const {
  return jobs(experiment);
}

std::string FidelityStage::key(const Experiment& experiment, const Job& job) const {
  return fidelity_key(dataset_of(experiment, job), scenes_);
}

nlohmann::json FidelityStage::run(const Job& job, const JobContext& context) const {
  ProgressFile progress(context.progress_file);
  return to_json(measure_fidelity(
      dataset_of(context.experiment, job), scenes_,
      [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total, ""); }));
}

void FidelityStage::check(const Experiment&, const nlohmann::json& record) const {
  fidelity_record_from_json(record);
}

void FidelityStage::collect(const Experiment& experiment, const Cache&, const JobRecords& records,
                            ExperimentResults& results) const {
  for (const DatasetSpec* dataset : experiment.datasets()) {
    if (dataset->measured()) continue;  // there is nothing to compare models on
    const Job job = job_of(*this, *dataset);
    FidelityOutcome& outcome = results.findings.of<FidelityOutcomes>().emplace_back();
    outcome.dataset = dataset->name;
    if (const auto record = records.read(job)) {
      outcome.rows = fidelity_rows(*dataset, fidelity_record_from_json(*record));
    } else {
      outcome.failure = records.why_missing(job).text();
    }
  }
}

std::vector<ReportSection> FidelityStage::report(const Experiment& experiment,
                                                 const ExperimentResults& results,
                                                 const std::filesystem::path& folder) const {
  report_fidelity(experiment, results.findings.found<FidelityOutcomes>(), results.builds, folder);
  return {};
}

}  // namespace ertbench
