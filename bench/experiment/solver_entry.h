#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// Why a solver, or a job of it, has no result.
struct Failure {
  std::string status;  ///< "failed", "timed out", "crashed", "out of memory", "not run"
  std::string message;

  std::string text() const { return message.empty() ? status : status + ": " + message; }
};

/// One solver to be fitted and scored. An entry of "solvers" stands for one, or for many: one for
/// each of its "seeds" at each point of its "sweep".
struct SolverEntry {
  /// The name of its row in all tables. The seeds of one entry share the label, and with it the
  /// row; the points of a sweep have labels, and rows, of their own.
  std::string label;
  std::string type;         ///< "dd-ert"
  JsonValue spec;           ///< the object that the solver is made from: no "seeds" and no "sweep"
  std::string path;         ///< where it stands in the file, for messages: "/solvers/2"
  std::optional<int> seed;  ///< the one of the entry's "seeds" that it is trained with
  /// What rows that differ by one setting share: "family" where the file gives one, else the
  /// entry's label without the values of a sweep.
  std::string family;
  JsonValue sweep;  ///< those values, `{"alpha": 0.001}`; null without a sweep
  /// Why it cannot be run, where that came out when it was checked: its plugin took its process
  /// down.
  std::optional<Failure> failure;
  /// What the registration of its type says (`describe`); nothing while that is not known.
  std::vector<std::string> inference_parameters;  ///< that have no part in the fit
  std::vector<std::string> file_parameters;       ///< that name files (ParameterRole::file)
  bool break_even_reference = false;              ///< what longer fits are held against by default

  /// Unique in the experiment, for file names: "dd-ert", "dd-ert.seed2".
  std::string stem() const { return seed ? label + ".seed" + std::to_string(*seed) : label; }
  /// The same for people: "dd-ert seed 2".
  std::string title() const { return seed ? label + " seed " + std::to_string(*seed) : label; }
};

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
