#include "bench/run/fidelity.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "core/progress.h"
#include "core/quantile.h"
#include "forward/border/border_model.h"
#include "forward/border/contact_arcs.h"
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

/// One model's numbers on one scene.
struct Outcome {
  double time_us = 0;  ///< its share of its block's
  double error = 0;    ///< noise units
  double estimate = 0;
  int points = 0;
};

/// The voltage changes of a block of scenes by one model, [scenes, channels] V.
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

using Outcomes = std::map<std::string, std::vector<Outcome>>;  ///< by model

/// Computes one block with every model in turn.
void measure_block(const Models& models, const DatasetSpec& spec, const std::vector<Scene>& scenes,
                   Outcomes& outcomes) {
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
      Outcome outcome;
      outcome.time_us = time.count() / static_cast<double>(scenes.size());
      outcome.error =
          (made.changes.row(static_cast<Eigen::Index>(i)).transpose() - exact[i]).norm() / noise;
      if (!made.solutions.empty()) {
        outcome.estimate = made.solutions[i].error / noise;
        outcome.points = made.solutions[i].points;
      }
      outcomes[name].push_back(outcome);
    }
  };
  measure("auto", [&] { return models.automatic(spec, scenes); });
  for (const int grid : grids) {
    measure(std::to_string(grid), [&] { return models.on_grid(grid, spec, scenes); });
  }
}

FidelityRow row_of(const DatasetSpec& spec, const std::string& scenes, const std::string& model,
                   const std::vector<Outcome>& outcomes) {
  FidelityRow row;
  row.dataset = spec.name;
  row.scenes = scenes;
  row.model = model;
  row.count = static_cast<int>(outcomes.size());
  row.bound = model_error_of(spec.model);
  std::vector<double> times;
  std::vector<double> errors;
  std::vector<double> ratios;
  for (const Outcome& outcome : outcomes) {
    times.push_back(outcome.time_us);
    errors.push_back(outcome.error);
    const bool kept = outcome.error <= row.bound;
    row.kept += kept;
    if (model != "auto") continue;
    const bool promised = outcome.estimate <= row.bound;
    row.promised += promised;
    row.promised_kept += promised && kept;
    if (outcome.error > 0) ratios.push_back(outcome.estimate / outcome.error);
    row.sizes.resize(std::size(fidelity_sizes) + 1);
    const auto size =
        std::lower_bound(std::begin(fidelity_sizes), std::end(fidelity_sizes), outcome.points);
    ++row.sizes[static_cast<std::size_t>(size - std::begin(fidelity_sizes))];
  }
  const SortedValues sorted_times = times;
  row.time_us = median(sorted_times);
  row.time_low = interpolated_quantile(sorted_times, 0.05);
  row.time_high = interpolated_quantile(sorted_times, 0.95);
  const SortedValues sorted_errors = errors;
  row.error_median = median(sorted_errors);
  row.error_p95 = interpolated_quantile(sorted_errors, 0.95);
  row.error_max = sorted_errors.largest();
  if (!ratios.empty()) row.tightness = median(ratios);
  return row;
}

}  // namespace

std::vector<FidelityRow> measure_fidelity(const Experiment& experiment, int scenes) {
  const Models models(experiment.sensor);
  std::vector<FidelityRow> rows;
  for (const DatasetSpec* spec : experiment.datasets()) {
    Progress progress("\"" + spec->name + "\"");
    Outcomes all;
    std::map<bool, Outcomes> parts;  // by smoothness
    std::map<bool, std::vector<Scene>> waiting;
    const auto measure = [&](bool smooth) {
      Outcomes some;
      measure_block(models, *spec, waiting[smooth], some);
      waiting[smooth].clear();
      for (const auto& [model, outcomes] : some) {
        for (auto* into : {&all[model], &parts[smooth][model]}) {
          into->insert(into->end(), outcomes.begin(), outcomes.end());
        }
      }
    };
    const std::uint64_t count =
        std::min<std::uint64_t>(spec->count, static_cast<std::uint64_t>(scenes));
    for (std::uint64_t i = 0; i < count; ++i) {
      Scene scene = spec->scene(i);
      const std::vector<ContactArc> arcs = contact_arcs(scene, *spec->sensor.sheet);
      if (arcs.empty()) continue;
      const bool smooth = is_smooth(arcs);
      waiting[smooth].push_back(std::move(scene));
      if (waiting[smooth].size() == fidelity_block) measure(smooth);
      progress.update(i + 1, count);
    }
    for (const bool smooth : {true, false}) {
      if (!waiting[smooth].empty()) measure(smooth);
    }
    const auto add = [&](const std::string& name, const Outcomes& outcomes) {
      for (const auto& model : {"auto", "24", "48", "96", "192"}) {
        if (outcomes.contains(model)) {
          rows.push_back(row_of(*spec, name, model, outcomes.at(model)));
        }
      }
    };
    if (parts.contains(true) && parts.contains(false)) {
      add("smooth", parts[true]);
      add("other", parts[false]);
    }
    add("all", all);
  }
  return rows;
}

}  // namespace ertbench
