#include "bench/record/stamps.h"

#include "bench/score/score_probe.h"
#include "forward/data/data_probes.h"
#include "solvers/registry/solver_probe.h"

namespace ertbench {

BuildStamp stamp_of_dataset(const DatasetSpec& spec) {
  return stamp_of_this_build(data_probes(spec));
}

BuildStamp stamp_of_fit(const FitRecipe& recipe) {
  Probes probes = solver_probes(recipe.entry.type);
  for (const auto* set : {&recipe.training, &recipe.validation}) {
    if (*set) probes.merge(data_probes(**set));
  }
  return stamp_of_this_build(std::move(probes), recipe.plugins);
}

BuildStamp stamp_of_record(const Experiment& experiment, const SolverEntry* entry) {
  Probes probes = {{"scores", score_probe()}};
  for (const DatasetSpec* spec : experiment.datasets()) probes.merge(data_probes(*spec));
  if (entry) probes.merge(solver_probes(entry->type));
  return stamp_of_this_build(std::move(probes), experiment.plugins);
}

BuildStamp stamp_of_limit(const DatasetSpec& set, const DatasetSpec& scenes) {
  Probes probes = data_probes(set);
  probes.merge(data_probes(scenes));
  if (has_cached_probe("limit")) probes["limit"] = cached_probe("limit", {});
  return stamp_of_this_build(std::move(probes));
}

Probes all_probes() {
  Probes out = all_data_probes();
  out.merge(all_solver_probes());
  out["scores"] = score_probe();
  return out;
}

Probes current_probes(const BuildStamp& made) {
  Probes out;
  const Probes data = all_data_probes();
  for (const auto& [name, probe] : made.probes) {
    const auto found = data.find(name);
    if (found != data.end()) out.insert(*found);
    if (name.starts_with("solver/")) out.merge(solver_probes(name.substr(7)));
  }
  return out;
}

}  // namespace ertbench
