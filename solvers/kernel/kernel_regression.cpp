#include "solvers/kernel/kernel_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/decompositions.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// Values tried for each hyperparameter.
std::vector<double> values_of(const Tunable& tunable, std::vector<double> tried) {
  return tunable.value ? std::vector{*tunable.value} : std::move(tried);
}

struct SearchedScales {
  std::vector<double> weights, widths, lambdas;
};

ChosenScales search(const SearchedScales& among, KernelInput input, const RowMajorMatrix& changes,
                    const Eigen::MatrixXd& targets) {
  ChosenScales best;
  best.error = std::numeric_limits<double>::infinity();
  for (const double weight : among.weights) {
    const RowMajorMatrix features = kernel_features(changes, input, weight);
    const Eigen::MatrixXd squared = squared_distances(features, features);
    const double median = median_distance(squared);
    for (const double width : among.widths) {
      const Eigen::MatrixXd kernel = radial_kernel(squared, width * median);
      const std::vector<Eigen::MatrixXd> residuals = leave_one_out(kernel, targets, among.lambdas);
      for (std::size_t l = 0; l < among.lambdas.size(); ++l) {
        const double error = residuals[l].rowwise().norm().mean();
        if (error < best.error) best = {{width, among.lambdas[l], weight}, error};
      }
    }
  }
  return best;
}

}  // namespace

KernelScaleChoice KernelScaleChoice::from_json(JsonObject& object) {
  return {read_tunable(object, "width", {1e-6, 1e6}), read_tunable(object, "lambda", {1e-12, 1e6}),
          read_tunable(object, "norm_weight", {0, 1e6})};
}

std::vector<Eigen::Index> spread_rows(Eigen::Index rows, Eigen::Index most) {
  std::vector<Eigen::Index> out(static_cast<std::size_t>(std::min(rows, most)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = static_cast<Eigen::Index>(i) * rows / static_cast<Eigen::Index>(out.size());
  }
  return out;
}

ChosenScales choose_scales(const KernelScaleChoice& choice, KernelInput input,
                           const RowMajorMatrix& changes, const Eigen::MatrixXd& targets) {
  SearchedScales among;
  among.widths = values_of(choice.width, {0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32});
  among.lambdas = values_of(choice.lambda, {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1});
  // Raw changes contain their norms.
  among.weights = input == KernelInput::raw ? std::vector<double>{0}
                                            : values_of(choice.norm_weight, {0, 0.1, 0.2, 0.5, 1});
  if (targets.rows() > 0 && (targets.rowwise() - targets.row(0)).isZero(0)) {
    return {{among.widths[0], among.lambdas[0], among.weights[0]}, 0};  // the intercept does it
  }
  const std::vector<Eigen::Index> few = spread_rows(changes.rows(), most_searched);
  const ChosenScales best =
      search(among, input, changes(few, Eigen::all), targets(few, Eigen::all));
  if (std::ssize(few) == changes.rows()) return best;
  among.weights = {best.scales.norm_weight};
  among.widths = {best.scales.width};
  return search(among, input, changes, targets);
}

RowMajorMatrix kernel_features(const Eigen::Ref<const RowMajorMatrix>& changes, KernelInput input,
                               double norm_weight) {
  if (input == KernelInput::raw) return changes;
  RowMajorMatrix out = RowMajorMatrix::Zero(changes.rows(), changes.cols() + 1);
  for (Index f = 0; f < changes.rows(); ++f) {
    const double norm = changes.row(f).norm();
    if (!(norm > 0)) continue;
    out.row(f).head(changes.cols()) = changes.row(f) / norm;
    if (norm_weight > 0) out(f, changes.cols()) = norm_weight * std::log(norm);
  }
  return out;
}

MatrixXd squared_distances(const RowMajorMatrix& a, const RowMajorMatrix& b) {
  MatrixXd out = -2 * a * b.transpose();
  out.colwise() += a.rowwise().squaredNorm();
  out.rowwise() += b.rowwise().squaredNorm().transpose();
  return out.cwiseMax(0);
}

MatrixXd radial_kernel(const MatrixXd& squared, double denominator) {
  return (-squared.array() / denominator).exp();
}

double median_distance(const MatrixXd& squared) {
  std::vector<double> distances;
  for (Index i = 0; i < squared.cols(); ++i) {
    for (Index j = i + 1; j < squared.rows(); ++j) distances.push_back(squared(j, i));
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle > 0 ? *middle : 1;
}

KernelRegression::KernelRegression(const RowMajorMatrix& changes, const MatrixXd& targets,
                                   KernelInput input, const KernelScales& scales)
    : input_(input),
      scales_(scales),
      features_(kernel_features(changes, input, scales.norm_weight)),
      squares_(features_.rowwise().squaredNorm()) {
  const MatrixXd squared = squared_distances(features_, features_);
  denominator_ = scales.width * median_distance(squared);
  MatrixXd kernel = radial_kernel(squared, denominator_);
  kernel.diagonal().array() += scales.lambda;
  const Eigen::LDLT<MatrixXd> factor(kernel);
  const VectorXd ones = factor.solve(VectorXd::Ones(kernel.rows()));
  const MatrixXd solved = factor.solve(targets);
  intercept_ = solved.colwise().sum() / ones.sum();
  coefficients_ = solved - ones * intercept_;
}

MatrixXd KernelRegression::predict(const Eigen::Ref<const RowMajorMatrix>& changes) const {
  const RowMajorMatrix features = kernel_features(changes, input_, scales_.norm_weight);
  MatrixXd out(changes.rows(), coefficients_.cols());
  // Frame by frame, so that a frame gives the same result alone and in a batch.
  for (Index f = 0; f < changes.rows(); ++f) {
    const VectorXd feature = features.row(f).transpose();
    VectorXd squared = squares_;
    squared.noalias() -= 2 * (features_ * feature);
    squared.array() += feature.squaredNorm();
    const VectorXd kernel = (-squared.cwiseMax(0).array() / denominator_).exp();
    out.row(f) = intercept_ + kernel.transpose() * coefficients_;
  }
  return out;
}

std::vector<MatrixXd> leave_one_out(const MatrixXd& kernel, const MatrixXd& targets,
                                    const std::vector<double>& lambdas) {
  const SymmetricEigen eigen = symmetric_eigen(kernel);
  const MatrixXd turned = eigen.vectors.transpose() * targets;
  const VectorXd turned_ones = eigen.vectors.transpose() * VectorXd::Ones(kernel.rows());
  std::vector<MatrixXd> out;
  for (const double lambda : lambdas) {
    const VectorXd inverse = (eigen.values.array().max(0) + lambda).inverse();
    const VectorXd ones = eigen.vectors * inverse.cwiseProduct(turned_ones);
    const MatrixXd solved = eigen.vectors * inverse.asDiagonal() * turned;
    const RowVectorXd intercept = solved.colwise().sum() / ones.sum();
    const VectorXd diagonal = eigen.vectors.cwiseAbs2() * inverse - ones.cwiseAbs2() / ones.sum();
    out.emplace_back(((solved - ones * intercept).array().colwise() / diagonal.array()).matrix());
  }
  return out;
}

}  // namespace ertbench
