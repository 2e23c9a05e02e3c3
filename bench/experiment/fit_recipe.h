#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

struct Experiment;

/// All that determines a fitted solver.
struct FitRecipe {
  SolverEntry entry;
  Sensor sensor;
  std::optional<DatasetSpec> training;
  std::optional<DatasetSpec> validation;
  std::vector<std::filesystem::path> plugins;  ///< libraries of the user's own solvers
  std::string source;                          ///< the experiment file, for messages
};

FitRecipe fit_recipe(const Experiment& experiment, const SolverEntry& entry);

}  // namespace ertbench
