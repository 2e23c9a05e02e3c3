#include "bench/experiment/solver_entry.h"

#include "bench/experiment/experiment.h"

namespace ertbench {

FitRecipe fit_recipe(const Experiment& experiment, const SolverEntry& entry) {
  return {entry,
          experiment.sensor,
          experiment.training,
          experiment.validation,
          experiment.plugins,
          experiment.source};
}

}  // namespace ertbench
