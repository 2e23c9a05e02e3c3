#include "bench/cli/command.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/solver_entry.h"
#include "core/errors.h"
#include "core/lists.h"
#include "core/text.h"
#include "frames/channels.h"

namespace ertbench {

std::span<const Command> commands() {
  static constexpr Command all[] = {
      {"run", add_run},
      {"report", add_report},
      {"check", nullptr, "tools", "Run an experiment and compare with its baseline"},
      {"generate", add_generate},
      {"reconstruct", add_reconstruct},
      {"publish", nullptr, "tools",
       "Make the results in results/published, and the pages that cite them"},
      {"list", add_list},
      {"timing", nullptr, "tools", "Run the timing benchmarks, beside the limits of this machine"},
      {"fidelity", nullptr, "tools",
       "Error and time of the forward models on an experiment's scenes"},
      {"limit", nullptr, "limit",
       "The least error that any method could have on an experiment's test sets"},
      {"calibrate", add_calibrate},
      {"score", add_score},
      {"export", nullptr, "tools", "A fitted solver as C code, for C++, as ONNX or as a matrix"},
      {"cache", add_cache},
      {"live", nullptr, "live", "Images, contacts and forces from a stream of frames"},
      {"trial", add_trial},
      {"probes", nullptr, "limit"},
      {"element", nullptr, "tools"}};
  return all;
}

void add_experiment(CLI::App& command, std::string& file) {
  command.add_option("EXPERIMENT.json", file)->required();
}

std::filesystem::path result_folder(const std::string& out, const std::string& experiment) {
  if (out.empty()) return std::filesystem::path("results") / experiment;
  const std::filesystem::path folder = out;
  // What earlier runs, limits, rates and checks have left.
  const auto has = [&](const char* name) { return std::filesystem::exists(folder / name); };
  if (!has("records") && !has("limit.json") && !has(".ertbench-check") &&
      std::filesystem::exists(folder) && !std::filesystem::is_empty(folder)) {
    throw InputError("--out " + printable_path(out) +
                     ": has files that are not of a run; name an empty or a new folder");
  }
  return folder;
}

void add_frame_options(CLI::App& command, OwnFramesOptions& options) {
  command.add_option(
      "--sensor", options.sensor,
      "JSON of the sensor, or an experiment with one (default: what the frames' file\n"
      "says, else EIDORS's d2s)");
  std::string orders;
  for (const NamedOrder& order : named_orders()) {
    orders += std::string("\n  ") + order.name + ": " + order.description;
  }
  command.add_option(
      "--channels", options.channels,
      "Order of the columns (default: the sensor's own, or full, by their number;\nof .eit files "
      "what they say):" +
          orders +
          "\n  or a file, or a dataset of the input (/NAME), with a line \"drive measurement\"\n"
          "  or \"drive measurement sign\" for each column, counted from 0;\n"
          "  or a file with the four electrodes of each, drive a, b and measurement m, n");
  command.add_option("--unit", options.unit,
                     "Of the numbers in the file: V, mV or uV (default: V)");
  command.add_option("--dataset", options.file.dataset,
                     "Dataset or variable with the frames (default: /voltages);\n"
                     "of .eit files with several frequencies the number of one, from 1");
  command.add_flag_function(
      "--transposed", [&options](std::int64_t times) { options.file.transposed = times > 0; },
      "Frames are columns of the file; --transposed=false: rows (default), also of a square table");
}

void require_usable_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_expected_max() == 0) continue;
    const bool number = option->get_type_name().starts_with("FLOAT");
    option->check([number](const std::string& value) -> std::string {
      if (value.empty()) return "must not be empty; is a variable of the shell unset?";
      const bool none = number && !std::isfinite(std::strtod(value.c_str(), nullptr));
      return none ? "must be a finite number" : "";
    });
  }
}

void add_device(CLI::App& command) {
  command
      .add_option_function<std::string>(
          "--device", [](const std::string& name) { ::setenv("ERTBENCH_DEVICE", name.c_str(), 1); },
          "That networks are trained on (default: auto, CUDA where there is\n"
          "one); images are made and timed on the CPU")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}));
}

namespace {

bool is_trained_in_bfloat16(const SolverEntry& entry) {
  return entry.spec->value("precision", nlohmann::json()) == "bfloat16";
}

/// Whether this processor multiplies in bfloat16 (AVX512-BF16). Where it does not even have AVX512,
/// libtorch does it number by number.
bool has_bfloat16() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512bf16") > 0;
#else
  return false;
#endif
}

}  // namespace

std::vector<std::string> precision_overrides(const Experiment& experiment,
                                             const std::string& precision) {
  std::vector<std::string> out;
  for (const SolverEntry& entry : experiment.solvers) {
    if (!is_trained_in_bfloat16(entry)) continue;
    std::string one = entry.path + "/precision=" + precision;
    if (std::ranges::find(out, one) == out.end()) out.push_back(std::move(one));
  }
  return out;
}

void warn_of_slow_trainings(const Experiment& experiment, const Cache& cache,
                            const std::vector<std::string>& only) {
  if (has_bfloat16()) return;
  std::set<std::string> labels;
  for (const SolverEntry& entry : experiment.solvers) {
    if (!entry.is_wanted(only) || !is_trained_in_bfloat16(entry)) continue;
    if (std::filesystem::exists(cache.fitted_solver(fit_recipe(experiment, entry)))) continue;
    labels.insert(entry.label);
  }
  if (labels.empty()) return;
  spdlog::warn(
      "{}: {} are trained in bfloat16, for which this processor has no instructions (AVX512-BF16): "
      "that may take many times as long as float32. `ertbench run --precision float32` trains them "
      "in float32, and so gives other networks than those of the published results",
      experiment.file.string(), joined(labels));
}

}  // namespace ertbench
