#include "solvers/total_variation/total_variation.h"

#include "forward/data/uniform_sheet.h"
#include "solvers/dense_svd.h"

namespace ertbench {

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
  // J = U S V^T: its kept rows are those of U S, whose decomposition is small, times V^T.
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
  const Eigen::Index block = GridLaplacian::block;
  const Eigen::Index padded = (channels() + block - 1) / block * block;
  jacobian_transposed_ = RowMajorMatrix::Zero(edges_.pixels(), padded);
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
