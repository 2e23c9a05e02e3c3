#include "solvers/total_variation/grid_laplacian.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ertbench {
namespace {

constexpr Eigen::Index lanes = 8;
using Lanes = Eigen::Array<double, lanes, 1>;

}  // namespace

GridLaplacian::GridLaplacian(int grid)
    : grid_(grid),
      unknowns_(Eigen::Index{grid} * grid - 1),
      stride_((grid + lanes - 1) / lanes * lanes + lanes),
      band_((unknowns_ + grid + 1) * stride_),
      inverse_diagonal_(unknowns_),
      ground_(unknowns_ + grid + 1) {}

void GridLaplacian::factor(const PixelEdges& edges, const Eigen::VectorXd& weights) {
  const Eigen::Index n = grid_;
  band_.setZero();
  ground_.setZero();
  for (Eigen::Index p = 0; p < unknowns_; ++p) {
    const Eigen::Index r = p / n;
    const Eigen::Index c = p % n;
    if (c < n - 1) row(p)[0] = weights[r * (n - 1) + c];
    if (r < n - 1) row(p)[n - 1] += weights[edges.across() + p];
  }
  // The two edges of the pixel held.
  ground_[unknowns_ - 1] = std::exchange(row(unknowns_ - 1)[0], 0.0);
  ground_[unknowns_ - n] += std::exchange(row(unknowns_ - n)[n - 1], 0.0);

  for (Eigen::Index j = 0; j < unknowns_; ++j) {
    double* const out = row(j);
    const Eigen::Map<Eigen::VectorXd> all(out, n);
    const double inverse = 1 / std::sqrt(all.sum() + ground_[j]);
    Eigen::Map<Eigen::VectorXd>(out, n) *= inverse;
    inverse_diagonal_[j] = inverse;
    const double grounded = ground_[j] * inverse;
    for (Eigen::Index i = 1; i <= n; ++i) {
      const double factor = out[i - 1];
      double* const target = row(j + i);
      // Reads past the band hit the zeros that pad it.
      for (Eigen::Index m = 0; m < n - i; m += lanes) {
        Eigen::Map<Lanes>(target + m) += factor * Eigen::Map<const Lanes>(out + i + m);
      }
      ground_[j + i] += factor * grounded;
    }
  }
}

void GridLaplacian::half_solve(const RowMajorMatrix& right, Eigen::Index columns,
                               RowMajorMatrix& out) const {
  using Block = Eigen::Array<double, block, 1>;
  for (Eigen::Index j = 0; j < unknowns_; ++j) {
    const Eigen::Index reach = std::min(grid_, j);
    for (Eigen::Index c = 0; c < columns; c += block) {
      Block sum = Eigen::Map<const Block>(&right(j, c));
      for (Eigen::Index i = 1; i <= reach; ++i) {
        sum += row(j - i)[i - 1] * Eigen::Map<const Block>(&out(j - i, c));
      }
      Eigen::Map<Block>(&out(j, c)) = sum * inverse_diagonal_[j];
    }
  }
}

void GridLaplacian::half_solve_transposed(RowMajorMatrix& x, Eigen::Index columns) const {
  using Block = Eigen::Array<double, block, 1>;
  for (Eigen::Index j = unknowns_; j-- > 0;) {
    const Eigen::Index reach = std::min(grid_, unknowns_ - 1 - j);
    const double* const factors = row(j);
    for (Eigen::Index c = 0; c < columns; c += block) {
      Block sum = Eigen::Map<const Block>(&x(j, c));
      for (Eigen::Index i = 1; i <= reach; ++i) {
        sum += factors[i - 1] * Eigen::Map<const Block>(&x(j + i, c));
      }
      Eigen::Map<Block>(&x(j, c)) = sum * inverse_diagonal_[j];
    }
  }
}

void GridLaplacian::half_solve(Eigen::VectorXd& x) const {
  for (Eigen::Index j = 0; j < unknowns_; ++j) {
    x[j] *= inverse_diagonal_[j];
    const Eigen::Index reach = std::min(grid_, unknowns_ - 1 - j);
    x.segment(j + 1, reach) += x[j] * Eigen::Map<const Eigen::VectorXd>(row(j), reach);
  }
}

void GridLaplacian::half_solve_transposed(Eigen::VectorXd& x) const {
  for (Eigen::Index j = unknowns_; j-- > 0;) {
    const Eigen::Index reach = std::min(grid_, unknowns_ - 1 - j);
    const double sum =
        Eigen::Map<const Eigen::VectorXd>(row(j), reach).dot(x.segment(j + 1, reach));
    x[j] = (x[j] + sum) * inverse_diagonal_[j];
  }
}

}  // namespace ertbench
