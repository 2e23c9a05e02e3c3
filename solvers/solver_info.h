#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/json.h"
#include "solvers/solver.h"

namespace ertbench {

/// Role of a parameter of a solver.
enum class ParameterRole {
  fit,        ///< changes the fit
  inference,  ///< changes how a fitted solver is applied, but not the fitted file, which solvers
              ///< that differ only by such parameters share; its name begins with "inference_"
  seed,       ///< seed of the training, an integer >= 0, called "seed"
  file,       ///< a file name relative to the experiment, or a list of words some of which are; the
              ///< contents of the files are part of the fit
};

/// One parameter of a solver, for `ertbench list` and for messages.
struct ParameterInfo {
  std::string name;
  std::string description;  ///< values, default, unit
  ParameterRole role = ParameterRole::fit;
};

/// How far `ertbench check` lets images of two builds or machines, fitted to the same data, differ.
enum class ImageComparison {
  /// By rounding: FMA and other kernels change the last bits only.
  rounding,
  /// By the solver's parameter "tolerance", the relative duality gap at which it stops: rounding
  /// may
  /// change the iteration at which that happens.
  duality_gap,
  /// As much as between training seeds: rounding grows into another network.
  seeds,
};

/// Registration of a type of solver.
struct SolverInfo {
  std::string summary;  ///< one line, with the formula or the source
  /// Without those that the registry adds to every solver (CheckedSolver).
  std::vector<ParameterInfo> parameters;
  /// Reads its keys from the object, from which the registry has read its own, and calls `finish`.
  std::function<std::unique_ptr<Solver>(JsonObject)> make;
  ImageComparison comparison = ImageComparison::rounding;
  /// True for the default reference of break-even charts: the method that one with a longer fit has
  /// to pay off against.
  bool break_even_reference = false;
  /// Settings, as JSON, that the type's probe (solvers/registry/solver_probe.h) is fitted with:
  /// small ones, which reach each of its algorithms. Empty for a type whose images are not made by
  /// this program.
  std::vector<std::string> probes = {"{}"};

  /// Null if it has no such parameter.
  const ParameterInfo* parameter(const std::string& name) const {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const ParameterInfo& p) { return p.name == name; });
    return found == parameters.end() ? nullptr : &*found;
  }
  /// True if its fit depends on a seed.
  bool has_seed() const {
    return std::any_of(parameters.begin(), parameters.end(),
                       [](const ParameterInfo& p) { return p.role == ParameterRole::seed; });
  }
};

/// A type of solver and its name in experiments.
struct SolverType {
  std::string name;
  SolverInfo info;
};

/// `SolverInfo::make` of a solver whose constructor takes a JsonObject.
template <typename T>
std::unique_ptr<Solver> make_from_json(JsonObject parameters) {
  return std::make_unique<T>(std::move(parameters));
}

}  // namespace ertbench
