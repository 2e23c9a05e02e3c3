#include "bench/fidelity.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/atomic_file.h"
#include "bench/progress.h"
#include "bench/provenance.h"
#include "bench/text.h"
#include "bench/text_table.h"
#include "forward/border_model.h"
#include "forward/contact_arcs.h"
#include "forward/forward_model.h"
#include "forward/rasterise.h"

namespace ertbench {
namespace {

constexpr int block = 16;  ///< scenes timed as one: two of the condensation's eight lanes
constexpr int grids[] = {24, 48, 96, 192};
constexpr double reference_share = 1e-3;  ///< of the bound, for the converged solution
constexpr int reference_points = 2500;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

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
        return spec.model_error * noise(spec, change);
      }));
      out.changes.row(static_cast<Eigen::Index>(i)) = out.solutions.back().change;
    }
    return out;
  }

  ModelledBlock on_grid(int grid, const DatasetSpec& spec, const std::vector<Scene>& scenes) const {
    const ForwardModel& model = grids_.at(grid);
    Images sheets(static_cast<Eigen::Index>(scenes.size()), grid * grid);
    Eigen::VectorXd ratio(grid * grid);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      rasterise(scenes[i], grid, Rasterisation::area, ratio);
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
                              return reference_share * spec.model_error *
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
  row.bound = spec.model_error;
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
  row.time_us = quantile(times, 0.5);
  row.time_low = quantile(times, 0.05);
  row.time_high = quantile(times, 0.95);
  row.error_median = quantile(errors, 0.5);
  row.error_p95 = quantile(errors, 0.95);
  row.error_max = quantile(errors, 1);
  row.tightness = quantile(ratios, 0.5);
  return row;
}

std::string csv_of(const std::vector<FidelityRow>& rows) {
  std::string out =
      "dataset,scenes,model,count,time_us,time_p5_us,time_p95_us,error_median,error_p95,error_max,"
      "bound,within_bound,promised,promised_and_kept,estimate_over_error";
  for (const int size : fidelity_sizes) out += ",points_to_" + std::to_string(size);
  out += ",points_more\n";
  for (const FidelityRow& row : rows) {
    char line[400];
    std::snprintf(line, sizeof line, "%s,%s,%s,%d,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%g,%d",
                  row.dataset.c_str(), row.scenes.c_str(), row.model.c_str(), row.count,
                  row.time_us, row.time_low, row.time_high, row.error_median, row.error_p95,
                  row.error_max, row.bound, row.kept);
    out += line;
    if (row.model == "auto") {
      std::snprintf(line, sizeof line, ",%d,%d,%.3g", row.promised, row.promised_kept,
                    row.tightness);
      out += line;
      for (const int count : row.sizes) out += "," + std::to_string(count);
    } else {
      out += std::string(4 + std::size(fidelity_sizes), ',');
    }
    out += "\n";
  }
  return out;
}

std::string markdown_of(const std::vector<FidelityRow>& rows, const Experiment& experiment) {
  TextTable table;
  table.caption = "The models";
  table.header = {"dataset",   "scenes",           "number",           "model",
                  "time (µs)", "scenes/s",         "median error",     "95 % of error",
                  "largest",   "within the bound", "kept of promised", "estimate / error"};
  for (const FidelityRow& row : rows) {
    const bool automatic = row.model == "auto";
    table.rows.push_back(
        {row.dataset, row.scenes, std::to_string(row.count), row.model,
         three_digits(row.time_us) + " (" + three_digits(row.time_low) + " to " +
             three_digits(row.time_high) + ")",
         three_digits(1e6 / row.time_us), three_digits(row.error_median),
         three_digits(row.error_p95), three_digits(row.error_max),
         fixed(100.0 * row.kept / row.count, 1) + " %",
         automatic ? std::to_string(row.promised_kept) + " of " + std::to_string(row.promised) : "",
         automatic ? three_digits(row.tightness) : ""});
  }
  return "# " + experiment.title + "\n\n" + experiment.question + "\n\n" +
         ertbench::markdown_of(table) +
         "\nErrors are 2-norms over the channels in units of the frame's noise, against the border "
         "integral equation at a thousandth of the bound. Times are of one thread, a scene: median "
         "of the blocks of " +
         std::to_string(block) +
         ", 5 to 95 % in brackets. \"smooth\" are "
         "scenes of whole discs and ellipses apart from each other, \"other\" those with corners, "
         "overlaps or contacts cut by the border of the sheet; blank scenes are left out. \"kept "
         "of "
         "promised\": scenes whose error is within the bound, of those whose estimate is.\n\nMade "
         "by "
         "`./ertbench fidelity experiments/" +
         experiment.name + ".json` on " + cpu_name() + ".\n";
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
      const std::vector<ContactArc> arcs = contact_arcs(scene);
      if (arcs.empty()) continue;
      const bool smooth = is_smooth(arcs);
      waiting[smooth].push_back(std::move(scene));
      if (waiting[smooth].size() == block) measure(smooth);
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

void run_fidelity(const Experiment& experiment, const FidelityOptions& options) {
  std::filesystem::create_directories(options.out);
  const std::vector<FidelityRow> rows = measure_fidelity(experiment, options.scenes);
  const std::string markdown = markdown_of(rows, experiment);
  write_file_atomically(options.out / "fidelity.csv", csv_of(rows));
  write_file_atomically(options.out / "fidelity.md", markdown);
  write_file_atomically(options.out / "provenance.json", provenance(experiment, 1).dump(2) + "\n");
  draw_fidelity_chart(rows, experiment.title, options.out / "fidelity");
  std::printf("%s\nResults in %s\n", markdown.c_str(), options.out.c_str());
}

}  // namespace ertbench
