#include "models/training/linear_estimate.h"

#include <Eigen/Cholesky>

namespace ertbench {
namespace {

constexpr double ridge = 1e-6;  ///< of the mean variance of the inputs

}  // namespace

LinearEstimate::LinearEstimate(Eigen::Index inputs, Eigen::Index outputs)
    : input_sum_(Eigen::VectorXd::Zero(inputs)),
      output_sum_(Eigen::VectorXd::Zero(outputs)),
      input_products_(Eigen::MatrixXd::Zero(inputs, inputs)),
      cross_products_(Eigen::MatrixXd::Zero(outputs, inputs)) {}

void LinearEstimate::add(const RowMajorMatrix& inputs, const RowMajorMatrix& outputs) {
  count_ += static_cast<double>(inputs.rows());
  input_sum_ += inputs.colwise().sum().transpose();
  output_sum_ += outputs.colwise().sum().transpose();
  input_products_.noalias() += inputs.transpose() * inputs;
  cross_products_.noalias() += outputs.transpose() * inputs;
}

LinearEstimate::Affine LinearEstimate::solve() const {
  const Eigen::VectorXd input_mean = input_sum_ / count_;
  const Eigen::VectorXd output_mean = output_sum_ / count_;
  Eigen::MatrixXd covariance = input_products_ / count_ - input_mean * input_mean.transpose();
  const Eigen::MatrixXd cross = cross_products_ / count_ - output_mean * input_mean.transpose();
  covariance.diagonal().array() += ridge * covariance.diagonal().mean();
  Affine out;
  out.weights = covariance.ldlt().solve(cross.transpose()).transpose();
  out.offset = output_mean - out.weights * input_mean;
  return out;
}

}  // namespace ertbench
