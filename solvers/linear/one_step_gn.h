#pragma once

#include <vector>

#include "solvers/linear/linear_solver.h"
#include "solvers/linear/masked_inverse.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// One-step Gauss-Newton reconstruction, the regularised solution of the linearised problem (A4):
///
///     image = (J^T J + lambda^2 R^T R)^-1 J^T changes
///
/// with J at the uniform background, in the conventions of EIDORS's inv_solve_diff_GN_one_step.
///
/// The matrix is computed by a SpectralInverse.
class OneStepGaussNewton final : public LinearSolver {
 public:
  static constexpr const char* type = "one-step-gn";

  /// `{"prior": "tikhonov" | "noser" | "laplace", "lambda": > 0 | "auto"}` and the keys of
  /// LinearInference and ChannelMask. The default prior NOSER evens out the sensitivity, which
  /// falls steeply away from the electrodes, and has the least error of the three on random
  /// contacts.
  explicit OneStepGaussNewton(JsonObject parameters);

  void fit(const FitInput& input) override;

 private:
  void read(JsonObject parameters) override;
  nlohmann::json fit_parameters() const override;
  void load_fit(const Hdf5File& file, const Sensor& sensor) override;
  std::unique_ptr<const FrameInverse> frame_inverse() const override;

  Prior prior_ = Prior::noser;
  Tunable lambda_;
};

/// The solvers of this room, for the registry.
std::vector<SolverType> linear_solvers();

}  // namespace ertbench
