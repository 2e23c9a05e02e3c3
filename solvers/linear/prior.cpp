#include "solvers/linear/prior.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace ertbench {
namespace {

/// The diagonal of J^T J, its square root.
Eigen::VectorXd sensitivities(const Eigen::MatrixXd& jacobian) {
  return jacobian.colwise().norm().transpose();
}

/// The Laplacian of a path of n pixels has the eigenvectors cos(pi k (i + 1/2) / n), and the
/// eigenvalues 2 - 2 cos(pi k / n); that of the grid their products and sums.
PriorFactors laplace_factors(int columns, int rows) {
  const auto path_of = [](int n, Eigen::VectorXd& values) {
    Eigen::MatrixXd path(n, n);
    values.resize(n);
    for (int k = 0; k < n; ++k) {
      values[k] = 2 - 2 * std::cos(std::numbers::pi * k / n);
      for (int i = 0; i < n; ++i) path(i, k) = std::cos(std::numbers::pi * k * (i + 0.5) / n);
    }
    path.colwise().normalize();
    return path;
  };
  Eigen::VectorXd values_x;
  Eigen::VectorXd values_y;
  const Eigen::MatrixXd path_x = path_of(columns, values_x);
  const Eigen::MatrixXd path_y = path_of(rows, values_y);
  Eigen::MatrixXd shaping(columns * rows, columns * rows - 1);
  for (int mode = 1; mode < columns * rows; ++mode) {
    const int kx = mode % columns;
    const int ky = mode / columns;
    const double scale = 1 / std::sqrt(2 * (values_x[kx] + values_y[ky]));
    for (int row = 0; row < rows; ++row) {
      shaping.col(mode - 1).segment(row * columns, columns) =
          scale * path_y(row, ky) * path_x.col(kx);
    }
  }
  return {shaping, true};
}

/// Columns of a square image where they are not given.
int columns_of(const Eigen::MatrixXd& jacobian, int columns) {
  return columns > 0
             ? columns
             : static_cast<int>(std::lround(std::sqrt(static_cast<double>(jacobian.cols()))));
}

}  // namespace

Prior prior_from_name(const std::string& name) {
  for (const Prior prior : {Prior::tikhonov, Prior::noser, Prior::laplace}) {
    if (name == name_of(prior)) return prior;
  }
  throw std::invalid_argument("no prior is called " + name);
}

const char* name_of(Prior prior) {
  switch (prior) {
    case Prior::tikhonov:
      return "tikhonov";
    case Prior::noser:
      return "noser";
    default:
      return "laplace";
  }
}

Eigen::MatrixXd prior_matrix(Prior prior, const Eigen::MatrixXd& jacobian, int columns) {
  const Eigen::Index pixels = jacobian.cols();
  if (prior == Prior::tikhonov) return Eigen::MatrixXd::Identity(pixels, pixels);
  if (prior == Prior::noser) return sensitivities(jacobian).asDiagonal();
  const Eigen::Index n = columns_of(jacobian, columns);
  Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(pixels, pixels);
  const auto join = [&](Eigen::Index p, Eigen::Index q) {
    laplacian(p, p) += 1;
    laplacian(q, q) += 1;
    laplacian(p, q) -= 1;
    laplacian(q, p) -= 1;
  };
  for (Eigen::Index p = 0; p < pixels; ++p) {
    if (p % n < n - 1) join(p, p + 1);
    if (p / n < pixels / n - 1) join(p, p + n);
  }
  return 2 * laplacian;
}

PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns) {
  const Eigen::Index pixels = jacobian.cols();
  if (prior == Prior::tikhonov) return {Eigen::MatrixXd::Identity(pixels, pixels), false};
  if (prior == Prior::laplace) {
    const int across = columns_of(jacobian, columns);
    return laplace_factors(across, static_cast<int>(pixels) / across);
  }
  // Pixels that no channel sees keep the value zero.
  const Eigen::VectorXd s = sensitivities(jacobian);
  const double unseen = 1e-14 * s.maxCoeff();
  const Eigen::VectorXd shaping =
      s.unaryExpr([unseen](double v) { return v > unseen ? 1 / std::sqrt(v) : 0.0; });
  return {shaping.asDiagonal().toDenseMatrix(), false};
}

}  // namespace ertbench
