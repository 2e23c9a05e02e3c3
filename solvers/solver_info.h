#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/json.h"
#include "solvers/solver.h"

namespace ertbench {

/// What part a parameter of a solver has.
enum class ParameterRole {
  fit,        ///< of what is fitted
  inference,  ///< how a fitted solver is applied: no part of `fit` or of the fitted file, which
              ///< solvers that differ by such parameters alone share; its name begins "inference_"
  seed,       ///< of the random numbers of a training, an integer >= 0, its name is "seed"
  file,       ///< names a file relative to the experiment, or is a list of words of which some do;
              ///< what is in the files is part of the fit
};

/// One parameter of a solver, for `ertbench list` and for messages.
struct ParameterInfo {
  std::string name;
  std::string description;  ///< values, default, unit
  ParameterRole role = ParameterRole::fit;
};

/// How far the images of two builds or two machines, fitted to the same data, may differ, which
/// `ertbench check` holds them to.
enum class ImageComparison {
  /// By rounding: FMA and other kernels change the last bits, and the image by no more than that.
  rounding,
  /// The solver stops where its relative duality gap falls below the parameter "tolerance", which
  /// last bits decide: by what such a gap leaves open.
  duality_gap,
  /// As another training seed would have it: last bits grow into another network.
  seeds,
};

/// What the registry and the benchmark know of a type of solvers.
struct SolverInfo {
  std::string summary;  ///< one line, with the formula or the source
  /// Without those that the registry adds to every solver's (CheckedSolver).
  std::vector<ParameterInfo> parameters;
  /// Reads its own keys from the object (those of the registry are taken already) and calls
  /// `finish`.
  std::function<std::unique_ptr<Solver>(JsonObject)> make;
  ImageComparison comparison = ImageComparison::rounding;
  /// Whether it is the kind of method that one with a longer fit has to pay off against, where a
  /// chart does not name another.
  bool break_even_reference = false;
  /// Settings, as JSON, that the type's probe (solvers/registry/solver_probe.h) is fitted with:
  /// small ones, which reach each of its algorithms. Empty for a type whose images are not made by
  /// this program.
  std::vector<std::string> probes = {"{}"};

  /// Null where it has no such parameter.
  const ParameterInfo* parameter(const std::string& name) const {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const ParameterInfo& p) { return p.name == name; });
    return found == parameters.end() ? nullptr : &*found;
  }
  /// Whether it is trained from random numbers, so that it comes out otherwise with another seed.
  bool has_seed() const {
    return std::any_of(parameters.begin(), parameters.end(),
                       [](const ParameterInfo& p) { return p.role == ParameterRole::seed; });
  }
};

/// A type of solvers by the name that experiments have for it.
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
