#pragma once

#include <optional>

#include "solvers/linear/linear_solver.h"
#include "solvers/parameter_choice.h"
#include "solvers/tunable.h"

namespace ertbench {

/// The matrix of the linear estimate of least mean squared error,
///
///     x = cross (changes + ridge m 1)^-1 d',   m the mean of the diagonal of `changes`,
///
/// from second moments `changes` [pairs, pairs] and `cross` [pixels, pairs]; `ridge` >= 0.
Eigen::MatrixXd mmse_matrix(const Eigen::MatrixXd& changes, const Eigen::MatrixXd& cross,
                            double ridge);

/// Linear minimum-mean-square-error reconstruction, type "lmmse" with one component: among all
/// matrices the one whose images have the least mean squared error over the training scenes,
///
///     image = E[x d^T] (E[d d^T] + ridge)^-1 changes.
///
/// It is the posterior mean where changes and images are jointly Gaussian with mean zero: no
/// contact gives no image. The moments are those of the training set, whose voltages carry its
/// noise and obey no linear model. (From C_xx by the Jacobian, C_xx J^T (J C_xx J^T + noise)^-1,
/// the mean relative error is .77 in place of .62 on one to three contacts: the linear model's bias
/// is taken for noise.) `ridge`, noise beyond that of the training set relative to the mean square
/// of the changes, trades error of strong contacts for error of weak ones.
class LinearMmse final : public LinearSolver {
 public:
  static constexpr const char* type = "lmmse";

  /// `{"components": 1, "ridge": > 0 | "auto", "symmetries": bool}` and what LinearInference and
  /// ChannelMask read.
  explicit LinearMmse(JsonObject parameters);

  nlohmann::json parameters() const override;
  bool needs_training() const override { return true; }
  void fit(const FitInput& input) override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  /// Reads what concerns the fit and calls `finish` of the object.
  void read(JsonObject parameters);
  nlohmann::json fit_parameters() const;
  std::unique_ptr<const MaskedInverse> masked_inverse() const override;

  bool symmetries_ = true;
  Tunable ridge_;
  std::optional<ParameterChoice> choice_;
  // Second moments of all pairs, from which frames with dead electrodes are imaged.
  Eigen::MatrixXd changes_;  ///< [pairs, pairs]
  Eigen::MatrixXd cross_;    ///< [pixels, pairs]
};

}  // namespace ertbench
