#include "solvers/total_variation/total_variation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "forward/data/sheet_model.h"
#include "solvers/decompositions.h"

namespace ertbench {
namespace {

constexpr Eigen::Index lanes = 8;
using Lanes = Eigen::Array<double, lanes, 1>;

/// Accumulates one row for a panel of right-hand sides that stays in `registers` SIMD registers.
/// `factor(i)` is the factor's i-th entry from the diagonal and `far(i)` the row of `x` that it
/// multiplies. The nearest row, which was finished last, is added last.
template <int registers, typename Far, typename Factor>
inline void solve_row(const double* right, double* out, Eigen::Index reach, double inverse,
                      const Far& far, const Factor& factor) {
  std::array<Lanes, registers> sum;
  for (int k = 0; k < registers; ++k) {
    sum[static_cast<std::size_t>(k)] = Eigen::Map<const Lanes>(right + k * lanes);
  }
  for (Eigen::Index i = reach; i > 0; --i) {
    const double weight = factor(i);
    const double* const x = far(i);
    for (int k = 0; k < registers; ++k) {
      sum[static_cast<std::size_t>(k)] += weight * Eigen::Map<const Lanes>(x + k * lanes);
    }
  }
  for (int k = 0; k < registers; ++k) {
    Eigen::Map<Lanes>(out + k * lanes) = sum[static_cast<std::size_t>(k)] * inverse;
  }
}

/// Divides the columns into panels as wide as the registers allow and calls `panel` with a
/// std::integral_constant of the number of registers and the first column.
template <typename Panel>
void for_panels(Eigen::Index columns, const Panel& panel) {
  Eigen::Index c = 0;
  for (; columns - c >= 64; c += 64) panel(std::integral_constant<int, 8>(), c);
  for (; columns - c >= 48; c += 48) panel(std::integral_constant<int, 6>(), c);
  for (; columns - c >= 32; c += 32) panel(std::integral_constant<int, 4>(), c);
  for (; c < columns; c += 16) panel(std::integral_constant<int, 2>(), c);
}

}  // namespace

GridLaplacian::GridLaplacian(int columns, int rows)
    : columns_(columns),
      rows_(rows),
      unknowns_(Eigen::Index{columns} * rows - 1),
      stride_((columns + lanes - 1) / lanes * lanes + lanes),
      band_((unknowns_ + columns + 1) * stride_),
      inverse_diagonal_(unknowns_),
      ground_(unknowns_ + columns + 1) {}

void GridLaplacian::factor(const PixelEdges& edges, const Eigen::VectorXd& weights) {
  const Eigen::Index n = columns_;
  band_.setZero();
  ground_.setZero();
  for (Eigen::Index p = 0; p < unknowns_; ++p) {
    const Eigen::Index r = p / n;
    const Eigen::Index c = p % n;
    if (c < n - 1) row(p)[0] = weights[r * (n - 1) + c];
    if (r < rows_ - 1) row(p)[n - 1] += weights[edges.across() + p];
  }
  // The two edges of the pixel held.
  ground_[unknowns_ - 1] = std::exchange(row(unknowns_ - 1)[0], 0.0);
  ground_[unknowns_ - n] += std::exchange(row(unknowns_ - n)[n - 1], 0.0);

  switch (columns_) {
    case 24:
      return eliminate<24>();
    case 25:  // the nodes of a 24-grid
      return eliminate<25>();
    default:
      return eliminate<Eigen::Dynamic>();
  }
}

/// `known`: the width of the band, or Dynamic. Loops of a known width are unrolled; otherwise their
/// branches cost more than their sums.
template <int known>
void GridLaplacian::eliminate() {
  using Row = Eigen::Matrix<double, known, 1>;
  const Eigen::Index n = known == Eigen::Dynamic ? columns_ : Eigen::Index{known};
  // Scales row j once all contributions to it are complete.
  const auto finish = [&](Eigen::Index j) {
    Eigen::Map<Row> all(row(j), n);
    const double inverse = 1 / std::sqrt(all.sum() + ground_[j]);
    all *= inverse;
    inverse_diagonal_[j] = inverse;
    ground_[j] *= inverse;
    Eigen::Map<Row>(ground_.data() + j + 1, n) += ground_[j] * all;
  };
  // Adds `factor` times the rest of a row from its i-th entry on.
  const auto add = [&](double* target, const double* out, Eigen::Index i, Eigen::Index left) {
    const double factor = out[i - 1];
    for (Eigen::Index m = 0; m < left * lanes; m += lanes) {
      Eigen::Map<Lanes>(target + m) += factor * Eigen::Map<const Lanes>(out + i + m);
    }
  };
  constexpr auto registers = [](Eigen::Index length) { return (length + lanes - 1) / lanes; };

  // Two rows at a time, so that the rows that they are added to are read and written half as often.
  Eigen::Index j = 0;
  for (; j + 1 < unknowns_; j += 2) {
    finish(j);
    const double* const first = row(j);
    const double* const second = row(j + 1);
    add(row(j + 1), first, 1, registers(n - 1));
    finish(j + 1);
    // Rows are grouped by the number of registers left; reads past the band hit its zero padding.
    Eigen::Index i = 2;
    for (Eigen::Index left = registers(n - 1); left > 0; --left) {
      for (; i <= n && n - i + 1 > (left - 1) * lanes; ++i) {
        const double a = first[i - 1];
        const double b = second[i - 2];
        double* const target = row(j + i);
        for (Eigen::Index m = 0; m < left * lanes; m += lanes) {
          Eigen::Map<Lanes>(target + m) += a * Eigen::Map<const Lanes>(first + i + m) +
                                           b * Eigen::Map<const Lanes>(second + i - 1 + m);
        }
      }
    }
  }
  for (; j < unknowns_; ++j) {
    finish(j);
    for (Eigen::Index i = 1; i < n; ++i) add(row(j + i), row(j), i, registers(n - i));
  }
}

void GridLaplacian::half_solve(const RowMajorMatrix& right, Eigen::Index columns,
                               RowMajorMatrix& out) const {
  static_assert(block == 2 * lanes);
  for_panels(columns, [&](auto registers, Eigen::Index c) {
    for (Eigen::Index j = 0; j < unknowns_; ++j) {
      solve_row<registers()>(
          &right(j, c), &out(j, c), std::min(columns_, j), inverse_diagonal_[j],
          [&](Eigen::Index i) { return &out(j - i, c); },
          [&](Eigen::Index i) { return row(j - i)[i - 1]; });
    }
  });
}

void GridLaplacian::half_solve_transposed(RowMajorMatrix& x, Eigen::Index columns) const {
  for_panels(columns, [&](auto registers, Eigen::Index c) {
    for (Eigen::Index j = unknowns_; j-- > 0;) {
      solve_row<registers()>(
          &x(j, c), &x(j, c), std::min(columns_, unknowns_ - 1 - j), inverse_diagonal_[j],
          [&](Eigen::Index i) { return &x(j + i, c); },
          [&](Eigen::Index i) { return row(j)[i - 1]; });
    }
  });
}

void GridLaplacian::half_solve(Eigen::VectorXd& x) const {
  for (Eigen::Index j = 0; j < unknowns_; ++j) {
    x[j] *= inverse_diagonal_[j];
    const Eigen::Index reach = std::min(columns_, unknowns_ - 1 - j);
    x.segment(j + 1, reach) += x[j] * Eigen::Map<const Eigen::VectorXd>(row(j), reach);
  }
}

void GridLaplacian::half_solve_transposed(Eigen::VectorXd& x) const {
  const auto one_row = [&](Eigen::Index j) {
    const Eigen::Index reach = std::min(columns_, unknowns_ - 1 - j);
    const double sum =
        Eigen::Map<const Eigen::VectorXd>(row(j), reach).dot(x.segment(j + 1, reach));
    x[j] = (x[j] + sum) * inverse_diagonal_[j];
  };
  // Eight rows at a time: their sums are independent of each other, and read memory that was
  // written long before.
  const Eigen::Index width = stride_ - lanes;
  Eigen::Index j = unknowns_;
  while (j > 0 && (j % lanes != 0 || j + width > unknowns_)) one_row(--j);
  while (j > 0) {
    j -= lanes;
    std::array<double, lanes> near;
    for (Eigen::Index r = 0; r < lanes; ++r) {
      const double* const factors = row(j + r) + lanes - 1 - r;
      Lanes sum = Lanes::Zero();
      for (Eigen::Index m = 0; m < width; m += lanes) {
        sum += Eigen::Map<const Lanes>(factors + m) *
               Eigen::Map<const Lanes>(x.data() + j + lanes + m);
      }
      near[static_cast<std::size_t>(r)] = x[j + r] + sum.sum();
    }
    for (Eigen::Index r = lanes; r-- > 0;) {
      const double value = near[static_cast<std::size_t>(r)] * inverse_diagonal_[j + r];
      x[j + r] = value;
      for (Eigen::Index q = 0; q < r; ++q) {
        near[static_cast<std::size_t>(q)] += row(j + q)[r - q - 1] * value;
      }
    }
  }
}

TotalVariation::TotalVariation(const Sensor& sensor)
    : reciprocity_(sensor),
      edges_(sensor.image_columns(), sensor.image_rows()),
      edge_length_(sensor.image().pixel().x()),
      laplacian_(sensor.image_columns(), sensor.image_rows()) {
  const DenseSvd svd = dense_svd(reciprocity_.reduce_rows(uniform_jacobian(sensor)));
  scale_ = svd.values[0];
  singular_values_ = svd.values / scale_;
  left_ = svd.left;
  set_right(svd.right);
}

TotalVariation::TotalVariation(const TotalVariation& whole, const Sensor& sensor,
                               ElectrodeSet masked)
    : TotalVariation(whole) {
  // J = U S V^T: the kept rows of J are those of U S, whose decomposition is small, times V^T.
  const std::vector<Eigen::Index> kept = pairs_without(sensor, masked);
  const Eigen::MatrixXd rows = (left_ * singular_values_.asDiagonal())(kept, Eigen::all);
  const DenseSvd svd = dense_svd(rows);
  const Eigen::MatrixXd right = right_ * svd.right;
  left_ = columns_for_all_pairs(svd.left.transpose(), kept, left_.rows()).transpose();
  scale_ *= svd.values[0];
  singular_values_ = svd.values / svd.values[0];
  set_right(right);
}

void TotalVariation::set_right(const Eigen::MatrixXd& right) {
  right_ = right;
  jacobian_transposed_ = RowMajorMatrix::Zero(edges_.pixels(), GridLaplacian::padded(channels()));
  jacobian_transposed_.leftCols(channels()) = right * singular_values_.asDiagonal();
  constant_ = jacobian_transposed_.colwise().sum().transpose();
  constant_gradient_ = jacobian_transposed_ * constant_;
  laplacian_.factor(edges_, Eigen::VectorXd::Ones(edges_.count()));
}

Eigen::VectorXd TotalVariation::project(const Eigen::Ref<const Eigen::RowVectorXd>& frame) const {
  Eigen::VectorXd data = Eigen::VectorXd::Zero(constant_.size());
  data.head(channels()).noalias() = left_.transpose() * reciprocity_.reduce(frame);
  return data;
}

}  // namespace ertbench
