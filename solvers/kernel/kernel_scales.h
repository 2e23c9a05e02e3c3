#pragma once

#include <nlohmann/json_fwd.hpp>

#include "solvers/kernel/kernel_regression.h"
#include "solvers/tunable.h"

namespace ertbench {

/// Scales as parameters have them, numbers or "auto".
struct KernelScaleChoice {
  Tunable width;
  Tunable lambda;
  Tunable norm_weight;

  /// Reads "width", "lambda" and "norm_weight".
  static KernelScaleChoice from_json(JsonObject& object);
};

/// Scales with the mean error that they were chosen by.
struct ChosenScales {
  KernelScales scales;
  double error = 0;  ///< mean over the frames of the length of what leaving one out misses
};

/// Of all combinations of the values that are tried for what is "auto" the one with the least mean
/// leave-one-out error.
ChosenScales choose_scales(const KernelScaleChoice& choice, KernelInput input,
                           const RowMajorMatrix& changes, const Eigen::MatrixXd& targets);

nlohmann::json to_json(const KernelScales& scales);

}  // namespace ertbench
