#include "bench/cli/training_precision.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/cli/command.h"

namespace ertbench {
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
    if (std::find(out.begin(), out.end(), one) == out.end()) out.push_back(std::move(one));
  }
  return out;
}

void warn_of_slow_trainings(const Experiment& experiment, const Cache& cache,
                            const std::vector<std::string>& only) {
  if (has_bfloat16()) return;
  std::set<std::string> labels;
  for (const SolverEntry& entry : experiment.solvers) {
    const bool wanted =
        only.empty() || std::any_of(only.begin(), only.end(), [&](const std::string& label) {
          return is_named(entry, label);
        });
    if (!wanted || !is_trained_in_bfloat16(entry)) continue;
    if (std::filesystem::exists(cache.fitted_solver(fit_recipe(experiment, entry)))) continue;
    labels.insert(entry.label);
  }
  if (labels.empty()) return;
  spdlog::warn(
      "{}: {} are trained in bfloat16, for which this processor has no instructions (AVX512-BF16): "
      "that may take many times as long as float32. `ertbench run --precision float32` trains them "
      "in "
      "float32, and so gives other networks than those of the published results",
      experiment.file.string(), list_of({labels.begin(), labels.end()}));
}

}  // namespace ertbench
