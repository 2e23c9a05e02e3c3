#include <algorithm>
#include <chrono>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "bench/fidelity/fidelity.h"
#include "bench/record/cache.h"
#include "bench/record/record_file.h"
#include "bench/run/job_runner.h"
#include "core/statistics.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Raised whenever scenes are measured differently, or the layout changes.
constexpr int fidelity_schema = 1;

const char* const model_names[] = {"auto", "24", "48", "96", "192"};  ///< in the order of the table

/// Visits the numbers that are kept of each scene.
template <typename Visit>
void visit_scene(const Visit& visit) {
  visit("smooth", &ModelledScene::smooth);
  visit("time_us", &ModelledScene::time_us);
  visit("error", &ModelledScene::error);
  visit("estimate", &ModelledScene::estimate);
  visit("points", &ModelledScene::points);
}

json scenes_json(const std::vector<ModelledScene>& scenes) {
  json out = json::object();
  for (const ModelledScene& scene : scenes) {
    visit_scene([&](const char* key, auto member) { out[key].push_back(scene.*member); });
  }
  return out;
}

std::vector<ModelledScene> scenes_from(const json& object) {
  std::vector<ModelledScene> scenes(object.at("smooth").size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    visit_scene([&](const char* key, auto member) {
      const json& value = object.at(key).at(i);
      using Number = std::decay_t<decltype(scenes[i].*member)>;
      // Frames without noise have an infinite error, which JSON cannot express.
      if constexpr (std::is_same_v<Number, double>) {
        if (value.is_null()) return void(scenes[i].*member = INFINITY);
      }
      scenes[i].*member = value.get<Number>();
    });
  }
  return scenes;
}

/// Fills in the estimates of "auto" and the sizes of its systems.
void add_promises(const std::vector<ModelledScene>& scenes, FidelityRow& row) {
  std::vector<double> ratios;
  row.sizes.resize(std::size(fidelity_sizes) + 1);
  for (const ModelledScene& scene : scenes) {
    const bool promised = scene.estimate <= row.bound;
    row.promised += promised;
    row.promised_kept += promised && scene.error <= row.bound;
    if (scene.error > 0) ratios.push_back(scene.estimate / scene.error);
    const auto size =
        std::lower_bound(std::begin(fidelity_sizes), std::end(fidelity_sizes), scene.points);
    ++row.sizes[static_cast<std::size_t>(size - std::begin(fidelity_sizes))];
  }
  if (!ratios.empty()) row.tightness = median(ratios);
}

FidelityRow row_of(const DatasetSpec& dataset, const std::string& kind, const std::string& model,
                   const std::vector<ModelledScene>& scenes) {
  FidelityRow row;
  row.dataset = dataset.name;
  row.scenes = kind;
  row.model = model;
  row.count = static_cast<int>(scenes.size());
  row.bound = model_error_of(dataset.model);
  std::vector<double> times;
  std::vector<double> errors;
  for (const ModelledScene& scene : scenes) {
    times.push_back(scene.time_us);
    errors.push_back(scene.error);
    row.kept += scene.error <= row.bound;
  }
  const SortedValues sorted_times = times;
  row.time_us = median(sorted_times);
  row.time_low = interpolated_quantile(sorted_times, 0.05);
  row.time_high = interpolated_quantile(sorted_times, 0.95);
  const SortedValues sorted_errors = errors;
  row.error_median = median(sorted_errors);
  row.error_p95 = interpolated_quantile(sorted_errors, 0.95);
  row.error_max = sorted_errors.largest();
  if (model == "auto") add_promises(scenes, row);
  return row;
}

std::vector<ModelledScene> of_kind(const std::vector<ModelledScene>& scenes, bool smooth) {
  std::vector<ModelledScene> out = scenes;
  std::erase_if(out, [&](const ModelledScene& scene) { return scene.smooth != smooth; });
  return out;
}

/// The number of scenes used if `scenes` are asked for, including those without contact.
std::uint64_t scenes_used(const DatasetSpec& dataset, int scenes) {
  return std::min<std::uint64_t>(dataset.count, static_cast<std::uint64_t>(scenes));
}

constexpr int grids[] = {24, 48, 96, 192};
constexpr double reference_share = 1e-3;  ///< of the bound, for the converged solution
constexpr int reference_points = 2500;

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

class FidelityStage final : public Stage {
 public:
  explicit FidelityStage(int scenes) : scenes_(scenes) {}

  std::string name() const override { return "fidelity"; }
  std::string noun() const override { return "dataset"; }
  bool wants_machine_alone() const override { return true; }
  bool reads_datasets() const override { return false; }  // it draws its scenes itself
  double time_limit_s(const Experiment& experiment) const override {
    // The limit is that of a trial; it grows with the number of scenes asked for.
    constexpr double scenes_of_one_limit = 500;
    return experiment.time_limit_s * std::max(1.0, scenes_ / scenes_of_one_limit);
  }
  std::vector<std::string> options() const override {
    return {"--scenes=" + std::to_string(scenes_)};
  }
  std::vector<Job> jobs(const Experiment& experiment) const override {
    std::vector<Job> jobs;
    for (const DatasetSpec* dataset : experiment.datasets()) {
      if (!dataset->measured()) jobs.push_back(job_of(*this, *dataset));
    }
    return jobs;
  }
  std::string key(const Experiment& experiment, const Job& job) const override {
    return fidelity_key(*experiment.find_dataset(job.subject), scenes_);
  }
  json run(const Job& job, const JobContext& context) const override {
    ProgressFile progress(context.progress_file);
    return to_json(measure_fidelity(
        *context.experiment.find_dataset(job.subject), scenes_,
        [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total, ""); }));
  }
  void check(const Experiment&, const json& record) const override {
    fidelity_record_from_json(record);
  }
  void collect(const Experiment& experiment, const Cache&, const JobRecords& records,
               ExperimentResults& results) const override {
    for (const Job& job : jobs(experiment)) {
      FidelityOutcome& outcome = results.findings.of<FidelityOutcomes>().emplace_back();
      outcome.dataset = job.subject;
      if (const auto record = records.read(job)) {
        outcome.rows = fidelity_rows(*experiment.find_dataset(job.subject),
                                     fidelity_record_from_json(*record));
      } else {
        outcome.failure = records.why_missing(job).text();
      }
    }
  }
  std::vector<ReportSection> report(const Experiment& experiment, const ExperimentResults& results,
                                    const std::filesystem::path& folder) const override {
    report_fidelity(experiment, results.findings.found<FidelityOutcomes>(), results.builds, folder);
    return {};
  }

 private:
  int scenes_;
};

}  // namespace

std::string fidelity_key(const DatasetSpec& dataset, int scenes) {
  const json key = {{"schema", fidelity_schema},
                    {"dataset", to_json(dataset)},
                    {"scenes", scenes_used(dataset, scenes)},
                    {"block", fidelity_block},
                    {"cpu", cpu_name()}};
  return hash_of(key.dump());
}

json to_json(const FidelityRecord& record) {
  json out = {{"schema", fidelity_schema}, {"models", json::object()}};
  for (const auto& [model, scenes] : record.models) out["models"][model] = scenes_json(scenes);
  return out;
}

FidelityRecord fidelity_record_from_json(const json& record) {
  FidelityRecord out;
  for (const auto& [model, scenes] : record.at("models").items()) {
    out.models[model] = scenes_from(scenes);
  }
  return out;
}

std::vector<FidelityRow> fidelity_rows(const DatasetSpec& dataset, const FidelityRecord& record) {
  std::vector<FidelityRow> parts;
  std::vector<FidelityRow> all;
  bool mixed = true;
  for (const bool smooth : {true, false}) {
    for (const char* model : model_names) {
      const auto found = record.models.find(model);
      if (found == record.models.end()) continue;
      const std::vector<ModelledScene> some = of_kind(found->second, smooth);
      mixed = mixed && !some.empty();
      if (!some.empty()) {
        parts.push_back(row_of(dataset, smooth ? "smooth" : "other", model, some));
      }
      if (smooth) all.push_back(row_of(dataset, "all", model, found->second));
    }
  }
  if (!mixed) return all;
  parts.insert(parts.end(), all.begin(), all.end());
  return parts;
}

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
  const std::uint64_t count = scenes_used(dataset, scenes);
  for (std::uint64_t i = 0; i < count; ++i) {
    Scene scene = dataset.scene(i);
    const std::vector<ContactArc> arcs = contact_arcs(scene, *dataset.sensor.sheet);
    if (arcs.empty()) continue;
    const bool smooth = std::ranges::all_of(arcs, &ContactArc::closed);
    waiting[smooth].push_back(std::move(scene));
    if (waiting[smooth].size() == fidelity_block) measure(smooth);
    progress(i + 1, count);
  }
  for (const bool smooth : {true, false}) {
    if (!waiting[smooth].empty()) measure(smooth);
  }
  return record;
}

std::unique_ptr<Stage> fidelity_stage(int scenes) {
  return std::make_unique<FidelityStage>(scenes);
}

}  // namespace ertbench
