#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// The reason why a solver, or one of its jobs, has no result.
struct Failure {
  std::string status;  ///< "failed", "timed out", "crashed", "out of memory", "not run"
  std::string message;

  std::string text() const { return message.empty() ? status : status + ": " + message; }
};

/// One solver to fit and score. An entry of "solvers" in the file makes one, or one for each of its
/// "seeds" at each point of its "sweep".
struct SolverEntry {
  /// Names its row in all tables. The seeds of one entry share the label and the row; each point of
  /// a sweep has its own.
  std::string label;
  std::string type;         ///< "dd-ert"
  JsonValue spec;           ///< parameters of the solver, without "seeds" and "sweep"
  std::string path;         ///< its place in the file, for messages: "/solvers/2"
  std::optional<int> seed;  ///< its training seed, one of the entry's "seeds"
  /// Shared by rows that differ by one setting: "family" of the file, else the entry's label
  /// without the values of a sweep.
  std::string family;
  JsonValue sweep;  ///< values of the sweep, `{"alpha": 0.001}`; null without one
  /// Set if the check of its parameters found that it cannot run: its plugin ended the process.
  std::optional<Failure> failure;
  // Copied from the registration of its type (`describe`); empty while that is not known.
  std::vector<std::string> inference_parameters;  ///< parameters without influence on the fit
  std::vector<std::string> file_parameters;       ///< parameters that name files
  bool break_even_reference = false;              ///< default reference for longer fits

  /// Unique in the experiment, for file names: "dd-ert", "dd-ert.seed2".
  std::string stem() const { return seed ? label + ".seed" + std::to_string(*seed) : label; }
  /// For people: "dd-ert seed 2".
  std::string title() const { return seed ? label + " seed " + std::to_string(*seed) : label; }
  /// Whether a name means it: its own label, or that of its whole sweep or family.
  bool is_named(const std::string& name) const { return label == name || family == name; }
  /// Whether one of the names of --only means it, or there are none, which asks for all.
  bool is_wanted(const std::vector<std::string>& only) const {
    return only.empty() ||
           std::ranges::any_of(only, [&](const std::string& name) { return is_named(name); });
  }
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
