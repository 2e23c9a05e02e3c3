#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/arrays.h"
#include "solvers/parameter_choice.h"

namespace ertbench {

/// Features by which the changes d of two frames are compared.
enum class KernelInput {
  direction,  ///< d / |d|, and log |d| times a weight
  raw,        ///< d itself
};

/// Hyperparameters of a kernel regression.
struct KernelScales {
  double width = 0.5;      ///< of the kernel, over the median squared distance of training frames
  double lambda = 1e-4;    ///< ridge
  double norm_weight = 0;  ///< of log |d| beside the direction; unused for raw changes

  bool operator==(const KernelScales&) const = default;
};

/// Features [frames, channels + 1 or channels]; all zero for a frame without a change.
RowMajorMatrix kernel_features(const Eigen::Ref<const RowMajorMatrix>& changes, KernelInput input,
                               double norm_weight);

/// Squared distances between all rows of `a` and all rows of `b`.
Eigen::MatrixXd squared_distances(const RowMajorMatrix& a, const RowMajorMatrix& b);

/// exp(-squared / denominator)
Eigen::MatrixXd radial_kernel(const Eigen::MatrixXd& squared, double denominator);

/// Median of the entries between different rows (two rows or more); 1 if the median is 0.
double median_distance(const Eigen::MatrixXd& squared);

/// Kernel ridge regression with an intercept (the least-squares support vector machine of Suykens
/// and Vandewalle 1999):
///
///     y(d) = b + sum_i a_i k(d, d_i),   k = exp(-|f(d) - f(d_i)|^2 / (width * median)),
///     [K + lambda 1   1] [a]   [y]
///     [1^T            0] [b] = [0].
class KernelRegression {
 public:
  KernelRegression() = default;
  /// `changes` [frames, channels], `targets` [frames, outputs].
  KernelRegression(const RowMajorMatrix& changes, const Eigen::MatrixXd& targets, KernelInput input,
                   const KernelScales& scales);

  /// [frames, outputs]
  Eigen::MatrixXd predict(const Eigen::Ref<const RowMajorMatrix>& changes) const;
  Eigen::Vector2d position(const Eigen::RowVectorXd& change) const {
    return predict(change).row(0).transpose();
  }

 private:
  KernelInput input_ = KernelInput::direction;
  KernelScales scales_;
  double denominator_ = 1;        ///< width * median
  RowMajorMatrix features_;       ///< [frames, features]
  Eigen::VectorXd squares_;       ///< [frames] their squared norms
  Eigen::MatrixXd coefficients_;  ///< [frames, outputs]
  Eigen::RowVectorXd intercept_;  ///< [outputs]
};

/// Leave-one-out residuals, target less prediction [frames, outputs], for each of `lambdas`. In
/// closed form a_i / (C^-1)_ii with the matrix C above (Cawley 2006), from one decomposition.
/// `kernel` [frames, frames].
std::vector<Eigen::MatrixXd> leave_one_out(const Eigen::MatrixXd& kernel,
                                           const Eigen::MatrixXd& targets,
                                           const std::vector<double>& lambdas);

/// Hyperparameters in the parameters of a solver, numbers or "auto".
struct KernelScaleChoice {
  Tunable width;
  Tunable lambda;
  Tunable norm_weight;

  /// Reads "width", "lambda" and "norm_weight".
  static KernelScaleChoice from_json(JsonObject& object);
};

/// Chosen hyperparameters.
struct ChosenScales {
  KernelScales scales;
  double error = 0;  ///< mean norm of the leave-one-out residuals
};

/// Presses on which scales are searched. They are relative to the frames, so that they hold for
/// more of them; only the ridge is chosen again on all.
constexpr Eigen::Index most_searched = 400;
/// At most `most` of so many rows, evenly spread, ascending.
std::vector<Eigen::Index> spread_rows(Eigen::Index rows, Eigen::Index most);

/// Chooses the hyperparameters given as "auto" from a grid, by the least mean leave-one-out error:
/// all on at most 400 frames, the ridge then on all frames.
ChosenScales choose_scales(const KernelScaleChoice& choice, KernelInput input,
                           const RowMajorMatrix& changes, const Eigen::MatrixXd& targets);

}  // namespace ertbench
