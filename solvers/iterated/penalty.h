#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "core/arrays.h"
#include "solvers/total_variation/grid_laplacian.h"
#include "solvers/total_variation/pixel_edges.h"

namespace ertbench {

/// What a Gauss-Newton step weighs against the data, as a function of coordinates z of the image t.
/// Holds the working memory of one thread; `pairs` below are those that are kept.
class Penalty {
 public:
  virtual ~Penalty() = default;

  virtual Eigen::Index coordinates() const = 0;
  /// t [pixels] of z.
  virtual void image(const Eigen::VectorXd& z, Eigen::VectorXd& t) const = 0;
  virtual double value(const Eigen::VectorXd& z) = 0;
  /// The z at which 1/2 |J t - data|^2 and the penalty (a quadratic above it that touches it at
  /// `now`, where it is none itself) are least together. J [pairs, pixels], data [pairs] V. False
  /// where rounding has made the system indefinite.
  virtual bool minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                        const Eigen::VectorXd& now, Eigen::VectorXd& z) = 0;
};

/// lambda^2 / 2 |z|^2 with t = E z: a Gaussian prior of covariance E E^T. In measurement space,
/// z = K^T (K K^T + lambda^2)^-1 data with K = J E: a system of the size of the pairs.
class ShapedPenalty final : public Penalty {
 public:
  /// E is the diagonal `shaping` [pixels, 1], or [pixels, coordinates]; it outlives the penalty.
  ShapedPenalty(const Eigen::MatrixXd& shaping, double lambda)
      : shaping_(shaping), lambda_(lambda) {}

  Eigen::Index coordinates() const override {
    return shaping_.cols() == 1 ? shaping_.rows() : shaping_.cols();
  }
  void image(const Eigen::VectorXd& z, Eigen::VectorXd& t) const override;
  double value(const Eigen::VectorXd& z) override {
    return lambda_ * lambda_ / 2 * z.squaredNorm();
  }
  bool minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                const Eigen::VectorXd& now, Eigen::VectorXd& z) override;

 private:
  const Eigen::MatrixXd& shaping_;
  double lambda_;
  RowMajorMatrix shaped_;  ///< K [pairs, coordinates]
  Eigen::MatrixXd gram_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd solved_;
};

/// A penalty on the differences e of t across the pixels' edges, z = t: the sum of weight e^2
/// (twice the pixel graph's Laplacian in lambda^2 R^T R, weight = lambda^2), or the smoothed total
/// variation, the sum of weight sqrt(e^2 + smoothing^2), above which the quadratic of lagged
/// diffusivity (Vogel, Oman 1996) lies.
///
/// The constant image costs nothing: t = t0 + c 1, the last pixel of t0 being zero, H = L L^T the
/// weighted Laplacian of the others. With G = L^-1 J^T, S = 1 + G^T G and k = J 1,
///
///     v = S^-1 (data - c k),   c = k^T S^-1 data / k^T S^-1 k,   t0 = L^-T G v.
class EdgePenalty final : public Penalty {
 public:
  /// `smoothing` <= 0: the sum of squares.
  EdgePenalty(int columns, int rows, double weight, double smoothing);

  Eigen::Index coordinates() const override { return edges_.pixels(); }
  void image(const Eigen::VectorXd& z, Eigen::VectorXd& t) const override { t = z; }
  double value(const Eigen::VectorXd& z) override;
  bool minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                const Eigen::VectorXd& now, Eigen::VectorXd& z) override;

 private:
  PixelEdges edges_;
  double weight_;
  double smoothing_;
  GridLaplacian laplacian_;
  Eigen::VectorXd difference_;  ///< [edges]
  Eigen::VectorXd curvature_;   ///< [edges]
  RowMajorMatrix transposed_;   ///< J^T [pixels, pairs rounded up]
  RowMajorMatrix half_;         ///< G
  Eigen::MatrixXd schur_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd constant_, constant_solve_, solved_;
};

}  // namespace ertbench
