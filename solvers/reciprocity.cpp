#include "solvers/reciprocity.h"

#include <cmath>
#include <numbers>

namespace ertbench {

Eigen::VectorXd Reciprocity::reduce(const Eigen::Ref<const Eigen::RowVectorXd>& frame) const {
  Eigen::VectorXd reduced(pairs());
  // Halved first, so that frames near the largest double do not overflow in the sum.
  for (Eigen::Index i = 0; i < pairs(); ++i) {
    const auto& [a, b] = pairs_[static_cast<std::size_t>(i)];
    reduced[i] = single_ ? frame[a] : (frame[a] / 2 + frame[b] / 2) * std::numbers::sqrt2;
  }
  return reduced;
}

Eigen::MatrixXd Reciprocity::reduce_rows(const RowMajorMatrix& jacobian) const {
  Eigen::MatrixXd reduced(pairs(), jacobian.cols());
  for (Eigen::Index i = 0; i < pairs(); ++i) {
    const auto& [a, b] = pairs_[static_cast<std::size_t>(i)];
    if (single_) {
      reduced.row(i) = jacobian.row(a);
    } else {
      reduced.row(i) = (jacobian.row(a) + jacobian.row(b)) / std::numbers::sqrt2;
    }
  }
  return reduced;
}

}  // namespace ertbench
