#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "solvers/solver_info.h"

namespace ertbench {

/// How a fitted matrix is applied to frames. The fitted file is the same for all of them.
struct LinearInference {
  bool single_precision = false;  ///< "inference_precision": "float64" | "float32"
  /// "inference_averaging": whether the two channels of a reciprocal pair are added before the
  /// product, which halves the matrix and changes nothing but rounding.
  bool averaging = true;

  /// For the solver's registration.
  static std::vector<ParameterInfo> registered();
  static LinearInference from_json(JsonObject& object);
  void add_to(nlohmann::json& parameters) const;
};

}  // namespace ertbench
