#pragma once

#include <torch/nn/modules/linear.h>

#include <optional>

#include "core/arrays.h"
#include "models/training/standardisation.h"
#include "solvers/solver.h"

namespace ertbench {

/// What the networks take from the physics.

/// The regularised inverse of the sensitivity, (J^T J + lambda^2 R^T R)^-1 J^T [pixels, channels]
/// in S/m per V, as the solver one-step-gn with the NOSER prior has it; lambda is chosen on the
/// validation set.
RowMajorMatrix sensitivity_inverse(const FitInput& input);

/// Makes of a dense layer [channels -> pixels] what one-step Gauss-Newton is, seen by a network:
/// standardised frames to y.
void set_sensitivity_inverse(torch::nn::Linear& layer, const FitInput& input,
                             const Standardisation& standardisation);

/// EIT-NN's blur of the target (Park et al. 2021): S = (J^T J + lambda^2 L)^-1 J^T J [pixels,
/// pixels], L the prior of one-step-gn "laplace", entries under a quarter of their column's largest
/// set to zero. `lambda`: none is chosen on the validation set.
RowMajorMatrix spatial_blur(const FitInput& input, std::optional<double> lambda);

}  // namespace ertbench
