#include "solvers/iterated/sheet_operator.h"

#include <numbers>

namespace ertbench {

void ShapedPenalty::image(const Eigen::VectorXd& z, Eigen::VectorXd& t) const {
  if (shaping_.cols() == 1) {
    t = shaping_.col(0).cwiseProduct(z);
  } else {
    t.noalias() = shaping_ * z;
  }
}

bool ShapedPenalty::minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                             const Eigen::VectorXd&, Eigen::VectorXd& z) {
  shaped_.resize(jacobian.rows(), coordinates());
  if (shaping_.cols() == 1) {
    shaped_ = jacobian.array().rowwise() * shaping_.col(0).transpose().array();
  } else {
    shaped_.noalias() = jacobian * shaping_;
  }
  gram_.setZero(jacobian.rows(), jacobian.rows());
  gram_.selfadjointView<Eigen::Lower>().rankUpdate(shaped_);
  gram_.diagonal().array() += lambda_ * lambda_;
  factor_.compute(gram_);
  if (factor_.info() != Eigen::Success) return false;
  solved_ = data;
  factor_.solveInPlace(solved_);
  z.noalias() = shaped_.transpose() * solved_;
  return true;
}

EdgePenalty::EdgePenalty(int columns, int rows, double weight, double smoothing)
    : edges_(columns, rows),
      weight_(weight),
      smoothing_(smoothing),
      laplacian_(columns, rows),
      difference_(edges_.count()),
      curvature_(edges_.count()) {}

double EdgePenalty::value(const Eigen::VectorXd& z) {
  edges_.differences(z, difference_);
  if (smoothing_ <= 0) return weight_ * difference_.squaredNorm();
  return weight_ *
         ((difference_.array().square() + smoothing_ * smoothing_).sqrt() - smoothing_).sum();
}

bool EdgePenalty::minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                           const Eigen::VectorXd& now, Eigen::VectorXd& z) {
  const Eigen::Index pairs = jacobian.rows();
  const Eigen::Index padded = GridLaplacian::padded(pairs);
  if (smoothing_ <= 0) {
    curvature_.setConstant(2 * weight_);
  } else {
    edges_.differences(now, difference_);
    curvature_ = weight_ * (difference_.array().square() + smoothing_ * smoothing_).rsqrt();
  }
  laplacian_.factor(edges_, curvature_);
  transposed_.resize(edges_.pixels(), padded);
  transposed_.leftCols(pairs) = jacobian.transpose();
  transposed_.rightCols(padded - pairs).setZero();
  half_.resize(edges_.pixels(), padded);
  laplacian_.half_solve(transposed_, padded, half_);

  const Eigen::Index unknowns = laplacian_.unknowns();
  const auto half = half_.topLeftCorner(unknowns, pairs);
  schur_.setIdentity(pairs, pairs);
  schur_.selfadjointView<Eigen::Lower>().rankUpdate(half.transpose());
  factor_.compute(schur_);
  if (factor_.info() != Eigen::Success) return false;
  constant_ = jacobian.rowwise().sum();
  constant_solve_ = constant_;
  factor_.solveInPlace(constant_solve_);
  solved_ = data;
  factor_.solveInPlace(solved_);
  const double c = constant_.dot(solved_) / constant_.dot(constant_solve_);
  solved_ -= c * constant_solve_;
  z.resize(edges_.pixels());
  z.head(unknowns).noalias() = half * solved_;
  laplacian_.half_solve_transposed(z);
  z[unknowns] = 0;
  z.array() += c;
  return true;
}

SheetOperator::SheetOperator(const Sensor& sensor)
    : columns_(sensor.image_columns()),
      rows_(sensor.image_rows()),
      edges_(columns_ + 1, rows_ + 1),
      stiffness_(columns_ + 1, rows_ + 1),
      weights_(edges_.count()),
      row_products_(rows_ + 1, columns_),
      column_products_(rows_, columns_ + 1) {
  const SensorPairs pairs(sensor);
  for (const auto& pair : reciprocal_pairs(sensor)) {
    const auto c = static_cast<std::size_t>(pair[0]);
    const auto& [measurement, drive] = pairs.channels[c];
    drives_.push_back({drive, measurement});
    scales_.push_back((pair[0] != pair[1] ? std::numbers::sqrt2 : 1) * pairs.currents[c] /
                      sensor.background);
  }
  const std::vector<int> electrodes = electrode_nodes(sensor, sensor.image_grid);
  const auto count = static_cast<Eigen::Index>(pairs.pairs.size());
  currents_ = RowMajorMatrix::Zero(edges_.pixels(), GridLaplacian::padded(count));
  for (Eigen::Index k = 0; k < count; ++k) {
    const ElectrodePair& pair = pairs.pairs[static_cast<std::size_t>(k)];
    currents_(electrodes[static_cast<std::size_t>(pair.first)], k) -= 1;
    currents_(electrodes[static_cast<std::size_t>(pair.second)], k) += 1;
  }
  // The node held by the factor has potential zero.
  half_ = RowMajorMatrix::Zero(edges_.pixels(), currents_.cols());
  products_.resize(count, count);
  fields_.resize(count, edges_.pixels());
  along_rows_.resize(count, edges_.across());
  along_columns_.resize(count, edges_.along());
  set_conductivity(Eigen::VectorXd::Ones(pixels()));
  uniform_ = products_;
}

void SheetOperator::set_conductivity(const Eigen::VectorXd& ratio) {
  // An edge carries half the sum of its neighbouring pixels' conductivities.
  const Eigen::Index m = rows_;
  const Eigen::Index n = columns_;
  const Eigen::Map<const RowMajorMatrix> half(ratio.data(), m, n);
  weights_.setZero();
  Eigen::Map<RowMajorMatrix> in_row(weights_.data(), m + 1, n);
  Eigen::Map<RowMajorMatrix> in_column(weights_.data() + edges_.across(), m, n + 1);
  in_row.topRows(m) += 0.5 * half;
  in_row.bottomRows(m) += 0.5 * half;
  in_column.leftCols(n) += 0.5 * half;
  in_column.rightCols(n) += 0.5 * half;
  stiffness_.factor(edges_, weights_);
  stiffness_.half_solve(currents_, currents_.cols(), half_);
  const auto used = half_.leftCols(products_.cols());
  products_.noalias() = used.transpose() * used;
}

void SheetOperator::changes(const std::vector<Eigen::Index>& kept, Eigen::VectorXd& out) const {
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const auto p = static_cast<std::size_t>(kept[i]);
    const auto [drive, measurement] = drives_[p];
    out[static_cast<Eigen::Index>(i)] =
        -scales_[p] * (products_(measurement, drive) - uniform_(measurement, drive));
  }
}

void SheetOperator::jacobian(const std::vector<Eigen::Index>& kept, RowMajorMatrix& out) {
  stiffness_.half_solve_transposed(half_, half_.cols());
  fields_ = half_.leftCols(products_.cols()).transpose();
  const Eigen::Index m = rows_;
  const Eigen::Index n = columns_;
  for (Eigen::Index k = 0; k < fields_.rows(); ++k) {
    const Eigen::Map<const RowMajorMatrix> u(fields_.row(k).data(), m + 1, n + 1);
    Eigen::Map<RowMajorMatrix>(along_rows_.row(k).data(), m + 1, n) =
        u.rightCols(n) - u.leftCols(n);
    Eigen::Map<RowMajorMatrix>(along_columns_.row(k).data(), m, n + 1) =
        u.bottomRows(m) - u.topRows(m);
  }
  // Half the sum, over the four edges of the pixel, of products of the two fields' differences.
  const auto flat = [](RowMajorMatrix& products) {
    return Eigen::Map<Eigen::RowVectorXd>(products.data(), products.size());
  };
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const auto p = static_cast<std::size_t>(kept[i]);
    const auto [drive, measurement] = drives_[p];
    flat(row_products_) =
        (0.5 * scales_[p]) * along_rows_.row(drive).cwiseProduct(along_rows_.row(measurement));
    flat(column_products_) = (0.5 * scales_[p]) * along_columns_.row(drive).cwiseProduct(
                                                      along_columns_.row(measurement));
    Eigen::Map<RowMajorMatrix>(out.row(static_cast<Eigen::Index>(i)).data(), m, n) =
        row_products_.topRows(m) + row_products_.bottomRows(m) + column_products_.leftCols(n) +
        column_products_.rightCols(n);
  }
}

}  // namespace ertbench
