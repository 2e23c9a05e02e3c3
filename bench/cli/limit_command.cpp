#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/plot/canvas.h"
#include "bench/record/limit_file.h"
#include "bench/record/record_file.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"
#include "limit/limit_run.h"
#include "limit/nested_sampler.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

/// Of the map: the numbers of electrodes that are compared, and the disc that they look for.
constexpr std::array map_electrodes = {8, 16, 32};
constexpr double map_radius = 0.2;

struct LimitArguments {
  std::string experiment;
  std::string out;
  std::string sampler = "auto";
  std::string prior = "both";
  bool fresh = false;
  bool map = false;
  bool nested = false;
  LimitOptions options;
};

/// "0.127 [0.120, 0.134], median 0.110"
std::string text_of(const MetricSummary& summary) {
  if (!summary.mean) return "undefined";
  std::string text = three_digits(*summary.mean);
  if (summary.ci95) {
    text += " [" + three_digits(summary.ci95->low) + ", " + three_digits(summary.ci95->high) + "]";
  }
  return text + ", median " + three_digits(*summary.median);
}

void print(const ResultRow& row) {
  JsonObject parameters(*row.parameters, limit_file, "/parameters");
  std::printf("%s, %s: %d frames, %d unresolved; voltages by %s\n", printable(row.dataset).c_str(),
              row.label.c_str(), row.frames, row.frames_not_converged,
              printable(parameters.text("model")).c_str());
  for (const char* name : limit_metrics) {
    const Metric metric = metric_from_name(name);
    std::printf("  %-14s %s\n", name, text_of(row.metrics[metric]).c_str());
  }
  const bool lower = row.type == limit_lower;
  JsonObject squares = parameters.object(lower ? "squared_error" : "calibration");
  const std::vector<double> ci95 = squares.numbers("ci95", 2);
  std::printf("  %s %.4f [%.4f, %.4f]\n",
              lower ? "mean squared error over that of an empty image"
                    : "squared error over posterior variance",
              squares.number(lower ? "over_empty" : "squared_error_over_variance"), ci95.at(0),
              ci95.at(1));
}

/// Throws InputError where no map can be drawn.
void require_map(const Experiment& experiment) {
  const Sensor& sensor = experiment.sensor;
  if (!sensor.electrode_places.empty()) {
    throw InputError(experiment.source +
                     ": --map compares numbers of electrodes at equal distances, and this sensor's "
                     "places are listed; leave --map out");
  }
  if (sensor.electrode_width * map_electrodes.back() >= sensor.sheet->border_length()) {
    throw InputError(experiment.source + ": --map: " + std::to_string(map_electrodes.back()) +
                     " electrodes of this width do not fit on the border; leave --map out");
  }
  if (sensor.sheet->inner_radius() <= map_radius) {
    throw InputError(experiment.source + ": --map: a disc of radius " + number_text(map_radius) +
                     " does not fit on this sheet; leave --map out");
  }
}

/// Removes the records of what is asked for, and of nothing else.
void forget(const Experiment& experiment, const LimitOptions& options) {
  for (const DatasetSpec& test : experiment.tests) {
    if (!options.datasets.empty() && !contains(options.datasets, test.name)) continue;
    std::filesystem::remove_all(options.records /
                                (test.name + (options.lower ? "_lower" : "_oracle")));
    if (!options.lower && options.fair)
      std::filesystem::remove_all(options.records / (test.name + "_fair"));
  }
}

/// The file's text: the limits, and what an earlier call left there of other sets and priors.
std::string text_of_file(const std::filesystem::path& file, const nlohmann::json& limits) {
  nlohmann::json all = limits;
  if (std::filesystem::exists(file)) {
    try {
      read_limit_rows(file.parent_path());
      all = with_others(limits, read_json_file(file));
    } catch (const std::exception& error) {
      spdlog::warn("{}: written anew, as it cannot be read: {}", file.string(), error.what());
    }
  }
  return all.dump(1) + "\n";
}

/// What other numbers of electrodes and less noise would buy, on the experiment's own sheet.
void draw_map(const Experiment& experiment, const std::filesystem::path& stem) {
  constexpr double ratio = 0.6;
  std::vector<BoundMap> maps;
  for (const int electrodes : map_electrodes) {
    Sensor sensor = experiment.sensor;
    sensor.electrode_offset *= static_cast<double>(sensor.electrode_count) / electrodes;
    sensor.electrode_count = electrodes;
    maps.push_back(bound_map(sensor, map_radius, ratio));
  }
  draw_bound_maps(maps,
                  "Cramér–Rao bound of a disc of unknown place, radius and conductivity (radius " +
                      number_text(map_radius) + ", ratio " + number_text(ratio) + ")",
                  stem);
}

/// "-812.31 ± 0.15"
std::string text_of(const Evidence& evidence) {
  return fixed(evidence.log, 2) + " ± " + fixed(evidence.deviation, 2);
}

/// Evidences of the frames of each set by annealing and by nested sampling, side by side.
ExitCode compare_evidences(const Experiment& experiment, const LimitOptions& options) {
  for (const DatasetSpec* set : sets_with_limit(experiment, options)) {
    std::printf(
        "%s: log evidence by annealing and by nested sampling, their difference;\n"
        "probability of each number of contacts, from 0, by both\n",
        printable(set->name).c_str());
    const auto shares = [](const std::vector<double>& numbers) {
      return joined(numbers, " ", [](double share) { return fixed(share, 3); });
    };
    std::vector<double> differences;
    double squares = 0;
    for (const EvidenceCheck& check : check_evidences(*set, options.frames, options.threads)) {
      std::printf("%4zu  %s  %s  %+.2f ± %.2f  %s | %s\n", differences.size(),
                  text_of(check.annealed).c_str(), text_of(check.nested).c_str(),
                  check.difference(), check.deviation(), shares(check.annealed_numbers).c_str(),
                  shares(check.nested_numbers).c_str());
      differences.push_back(check.difference());
      squares += std::pow(check.difference() / check.deviation(), 2);
    }
    const Interval ci95 = bootstrap_interval_of_mean(differences, "evidences");
    std::printf("mean difference %.2f [%.2f, %.2f], root mean square %.2f deviations\n",
                mean(differences), ci95.low, ci95.high,
                std::sqrt(squares / static_cast<double>(differences.size())));
  }
  return done;
}

ExitCode limit(const LimitArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment =
      read_experiment(arguments.experiment, registry, {}, SolverCheck::none);
  if (arguments.nested) return compare_evidences(experiment, arguments.options);
  const std::filesystem::path folder = result_folder(arguments.out, experiment.name);
  LimitOptions options = arguments.options;
  const std::vector<std::string>& samplers = names_of_samplers();
  options.sampler =
      static_cast<SamplerKind>(std::ranges::find(samplers, arguments.sampler) - samplers.begin());
  options.fair = arguments.prior == "both";
  options.records = folder / "limit";
  if (arguments.map) require_map(experiment);
  if (arguments.fresh) forget(experiment, options);
  std::vector<ResultRow> rows;
  const std::filesystem::path ranks = folder / "limit_ranks";
  bool drawn = true;
  if (!arguments.fresh && (options.lower || std::filesystem::exists(ranks.string() + ".png"))) {
    rows = finished_limits(folder, experiment, options);
  }
  if (rows.empty()) {
    const std::vector<SetLimit> limits = compute_limits(experiment, options);
    write_file_atomically(folder / limit_file,
                          text_of_file(folder / limit_file, limit_json(experiment.name, limits)));
    drawn = options.lower || draw_or_say(ranks, [&] {
              draw_rank_figure(
                  limits, experiment.title + ": ranks of the truths among their posteriors", ranks);
            });
    for (const SetLimit& set : limits) rows.push_back(row_of(set));
  } else {
    spdlog::info("{}: has all of it, of this code and these sets; --fresh computes it again",
                 printable_path((folder / limit_file).string()));
  }
  if (arguments.map) draw_map(experiment, folder / "limit_map");
  for (const ResultRow& row : rows) print(row);
  std::printf("%s\n", printable_path((folder / limit_file).string()).c_str());
  return drawn ? done : trial_failed;
}

}  // namespace

static Action add_limit(CLI::App& command) {
  const auto arguments = std::make_shared<LimitArguments>();
  LimitOptions& options = arguments->options;
  add_experiment(command, arguments->experiment);
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT)");
  command.add_option("--dataset", options.datasets, "Only these test sets (default: all)")
      ->delimiter(',');
  command.add_option("--frames", options.frames, "Frames of each set, the first (default: 100)")
      ->check(CLI::Range(1, 1000000));
  command.add_option("--threads", options.threads, "Frames at a time (default: 1)")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--sampler", arguments->sampler,
                  "Of the posterior: auto, enumeration, importance, annealing (default: auto)")
      ->check(CLI::IsMember(names_of_samplers()));
  command
      .add_option(
          "--prior", arguments->prior,
          "both: limit-oracle and limit-fair; oracle: that alone, which for single discs takes "
          "seconds (default: both)")
      ->check(CLI::IsMember({"both", "oracle"}));
  command.add_flag("--lower", options.lower,
                   "Compute limit-lower in place of these rows: a lower bound of every method's "
                   "error, by chains that start at each frame's own scene");
  command
      .add_flag("--nested", arguments->nested,
                "Only compare the evidences of --frames under limit-oracle's prior with those of\n"
                "nested sampling, and print them: minutes a frame of several contacts")
      ->excludes("--lower");
  command.add_flag("--map", arguments->map,
                   "Also draw the Cramér-Rao bound over the sheet (limit_map.png)");
  command.add_flag("--fresh", arguments->fresh,
                   "Compute again what is finished already of these sets and priors");
  command.footer(
      "Example:\n  ertbench limit experiments/table_c1_fine.json --prior oracle --threads 2\n"
      "Samples the posterior over scenes of each frame, under the distribution of the test scenes\n"
      "(limit-oracle) and of the training scenes (limit-fair), and scores the best estimates.\n"
      "Writes limit.json beside the results, which `ertbench run` shows as rows and as a line of\n"
      "its charts, and keeps what it says of other sets and priors. A call that was cut off goes "
      "on\n"
      "where it stopped, and a limit.json that has all that is asked for, of this code and these\n"
      "sets, is left as it is. See docs/limit.md.");
  return [arguments] { return limit(*arguments); };
}

static Action add_probes(CLI::App& command) {
  // Hidden: the probes of this program as JSON, by name; used by tests.
  const auto against = std::make_shared<std::string>();
  command.add_option(
      "--against", *against,
      "Such a file: print only by how much of their norms the probes differ from it");
  return [against] {
    Probes probes = all_probes();
    probes["limit"] = limit_probe();
    nlohmann::json out = to_json(probes);
    if (!against->empty()) {
      const Probes made = probes_from_json(read_json_file(*against));
      out = nlohmann::json::object();
      for (const auto& [name, probe] : probes) {
        if (probe_difference(made, {{name, probe}}).empty()) continue;
        out[name] = made.contains(name) ? fixed(difference(made.at(name), probe), 6) : "new";
      }
    }
    std::printf("%s\n", json_text(out).c_str());
    return done;
  };
}

}  // namespace ertbench

extern "C" void ertbench_part_limit(ertbench::Part& part) {
  static constexpr ertbench::Command commands[] = {{"limit", ertbench::add_limit},
                                                   {"probes", ertbench::add_probes}};
  part.commands = commands;
}
