#include "solvers/total_variation.h"

#include "forward/forward_model.h"
#include "solvers/dense_svd.h"

namespace ertbench {

TotalVariation::TotalVariation(const Sensor& sensor)
    : reciprocity_(sensor), edges_(sensor.image_grid), laplacian_(sensor.image_grid) {
  const DenseSvd svd =
      dense_svd(reciprocity_.reduce_rows(ForwardModel(sensor, sensor.image_grid).jacobian()));
  scale_ = svd.values[0];
  singular_values_ = svd.values / scale_;
  left_ = svd.left;

  const Eigen::Index block = GridLaplacian::block;
  const Eigen::Index padded = (channels() + block - 1) / block * block;
  jacobian_transposed_ = RowMajorMatrix::Zero(edges_.pixels(), padded);
  jacobian_transposed_.leftCols(channels()) = svd.right * singular_values_.asDiagonal();
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
