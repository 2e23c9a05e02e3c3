#include "bench/score/explained_change.h"

#include <Eigen/QR>
#include <algorithm>

#include "forward/data/uniform_sheet.h"

namespace ertbench {

ExplainedChange::ExplainedChange(const Sensor& sensor, const Eigen::VectorXd& reference)
    : jacobian_(uniform_jacobian(sensor)), reference_(reference) {}

std::optional<double> ExplainedChange::of(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                          const Eigen::Ref<const Eigen::RowVectorXd>& image) const {
  const double size = change.norm();
  if (!(size > 0)) return std::nullopt;
  Eigen::MatrixXd responses(change.size(), 2);
  responses.col(0) = jacobian_ * image.transpose();
  responses.col(1) = reference_;
  // Of an image of nothing the first column is zero, which the decomposition leaves out.
  const auto decomposed = responses.completeOrthogonalDecomposition();
  const Eigen::VectorXd best = decomposed.solve(change.transpose());
  const double left = (change.transpose() - responses * best).norm();
  return std::clamp(1 - left / size, 0.0, 1.0);
}

}  // namespace ertbench
