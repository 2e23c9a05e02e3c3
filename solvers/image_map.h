#pragma once

#include <Eigen/Core>

namespace ertbench {

/// A linear map of frames to images, kept as `left` or as the product `left right`: a matrix of low
/// rank has fewer numbers in its two factors, and what a frame costs is reading them once.
template <typename Scalar>
struct ImageMap {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  Matrix left;   ///< [pixels, inputs], or [pixels, rank]
  Matrix right;  ///< empty, or [rank, inputs]

  bool factored() const { return right.size() > 0; }
  Eigen::Index inputs() const { return factored() ? right.cols() : left.cols(); }
  Eigen::Index pixels() const { return left.rows(); }
  /// Numbers that one frame reads.
  Eigen::Index size() const { return left.size() + right.size(); }

  template <typename Other>
  ImageMap<Other> cast() const {
    return {left.template cast<Other>(), right.template cast<Other>()};
  }
};

/// The product as it is cheaper: its factors, or multiplied out.
inline ImageMap<double> smaller_map(Eigen::MatrixXd left, Eigen::MatrixXd right) {
  if (left.size() + right.size() < left.rows() * right.cols()) {
    return {std::move(left), std::move(right)};
  }
  return {left * right, {}};
}

}  // namespace ertbench
