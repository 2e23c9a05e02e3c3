#include "solvers/total_variation.h"

#include <Eigen/SVD>

#include "forward/forward_model.h"

namespace ertbench {

TotalVariation::TotalVariation(const Sensor& sensor)
    : reciprocity_(sensor), edges_(sensor.image_grid), laplacian_(sensor.image_grid) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(
      reciprocity_.reduce_rows(ForwardModel(sensor, sensor.image_grid).jacobian()),
      Eigen::ComputeThinU | Eigen::ComputeThinV);
  scale_ = svd.singularValues()[0];
  singular_values_ = svd.singularValues() / scale_;
  left_ = svd.matrixU();

  const Eigen::Index block = GridLaplacian::block;
  const Eigen::Index padded = (channels() + block - 1) / block * block;
  jacobian_transposed_ = RowMajorMatrix::Zero(edges_.pixels(), padded);
  jacobian_transposed_.leftCols(channels()) = svd.matrixV() * singular_values_.asDiagonal();
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
