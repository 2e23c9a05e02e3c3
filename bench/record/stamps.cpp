#include "bench/record/stamps.h"

#include <algorithm>

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

namespace {

/// True if frames are worsened, whose faults the front then sees.
bool has_faults(const Experiment& experiment) {
  const auto sets = experiment.datasets();
  const auto& studies = experiment.studies;
  return experiment.ladders ||
         std::any_of(sets.begin(), sets.end(), [](const auto* set) { return set->faults.any(); }) ||
         std::any_of(studies.begin(), studies.end(),
                     [](const StudySpec& study) { return study.type == "arm_hour"; });
}

}  // namespace

BuildStamp stamp_of_record(const Experiment& experiment, const SolverEntry* entry) {
  Probes probes = {{"scores", score_probe()}};
  for (const DatasetSpec* spec : experiment.datasets()) probes.merge(data_probes(*spec));
  if (entry) probes.merge(solver_probes(entry->type));
  if (entry && has_faults(experiment)) probes["front"] = front_probe();
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
  out["front"] = front_probe();
  return out;
}

Probes current_probes(const BuildStamp& made) {
  Probes out;
  const Probes data = all_data_probes();
  for (const auto& [name, probe] : made.probes) {
    const auto found = data.find(name);
    if (found != data.end()) out.insert(*found);
    if (name == "front") out[name] = front_probe();
    if (name.starts_with("solver/")) out.merge(solver_probes(name.substr(7)));
  }
  return out;
}

}  // namespace ertbench
