#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "solvers/total_variation/total_variation.h"

namespace ertbench {

/// Change of variables for the conductivity: any t (S/m) is a conductivity between the bounds, and
/// small t are changes from the background, so that a penalty on t means the same as for linear
/// solvers. With s = conductivity / background, low < s < high,
///
///     s = low + (high - low) / (1 + (high - 1) / (1 - low) exp(-a t / background)),
///     a = (high - low) / ((1 - low) (high - 1)),
///
/// a logistic curve through s = 1 at t = 0 with slope 1 / background.
class BoundedConductivity {
 public:
  BoundedConductivity() = default;
  /// 0 <= low < 1 < high.
  BoundedConductivity(double background, double low, double high)
      : background_(background),
        low_(low),
        high_(high),
        rate_((high - low) / ((1 - low) * (high - 1)) / background),
        odds_((high - 1) / (1 - low)) {}

  /// s and ds/dt, 1 / (S/m), for every t.
  void ratios(const Eigen::VectorXd& t, Eigen::VectorXd& ratio, Eigen::VectorXd& slope) const {
    ratio = low_ + (high_ - low_) / (1 + odds_ * (-rate_ * t.array()).exp());
    // Rounding must not move a conductivity onto its bound, which may be zero.
    ratio = ratio.array().max(low_ + least).min(high_);
    slope = rate_ / (high_ - low_) * (ratio.array() - low_) * (high_ - ratio.array());
  }

  /// t of conductivities [n] S/m; values outside the bounds are clamped.
  template <typename Derived>
  auto variable(const Eigen::ArrayBase<Derived>& conductivity) const {
    constexpr double inside = 1e-3;
    return ((conductivity / background_)
                .max(low_ + inside * (1 - low_))
                .min(high_ - inside * (high_ - 1)))
        .unaryExpr([low = low_, high = high_, rate = rate_, odds = odds_](double s) {
          return -std::log((high - s) / (s - low) / odds) / rate;
        });
  }

 private:
  static constexpr double least = 1e-9;

  double background_ = 1;
  double low_ = 0;
  double high_ = 2;
  double rate_ = 2;
  double odds_ = 1;
};

/// Penalty of a Gauss-Newton step as a function of coordinates z of the image t. Holds the working
/// memory of one thread; `pairs` below are the kept ones.
class Penalty {
 public:
  virtual ~Penalty() = default;

  virtual Eigen::Index coordinates() const = 0;
  /// Computes t [pixels] from z.
  virtual void image(const Eigen::VectorXd& z, Eigen::VectorXd& t) const = 0;
  virtual double value(const Eigen::VectorXd& z) = 0;
  /// Minimises 1/2 |J t - data|^2 + penalty over z; a penalty that is not quadratic is replaced by
  /// a quadratic that lies above it and touches it at `now`. J [pairs, pixels], data [pairs] V.
  /// False if rounding has made the system indefinite.
  virtual bool minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                        const Eigen::VectorXd& now, Eigen::VectorXd& z) = 0;
};

/// lambda^2 / 2 |z|^2 with t = E z: a Gaussian prior of covariance E E^T. Solved in measurement
/// space, z = K^T (K K^T + lambda^2)^-1 data with K = J E.
class ShapedPenalty final : public Penalty {
 public:
  /// E is a diagonal, `shaping` [pixels, 1], or [pixels, coordinates]; must outlive the penalty.
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

/// Penalty on the differences e of t across pixel edges, with z = t: the sum of weight e^2 (in
/// lambda^2 R^T R twice the Laplacian of the pixel graph, weight = lambda^2), or the smoothed total
/// variation, the sum of weight sqrt(e^2 + smoothing^2), majorised by the quadratic of lagged
/// diffusivity (Vogel, Oman 1996).
///
/// A constant image has no penalty: t = t0 + c 1, where the last pixel of t0 is zero and H = L L^T
/// is the weighted Laplacian of the others. With G = L^-1 J^T, S = 1 + G^T G and k = J 1,
///
///     v = S^-1 (data - c k),   c = k^T S^-1 data / k^T S^-1 k,   t0 = L^-T G v.
class EdgePenalty final : public Penalty {
 public:
  /// `smoothing` <= 0 selects the sum of squares.
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

/// Voltages and Jacobian of the grid model (ForwardModel on the image's grid), reduced by
/// reciprocity (Reciprocity), for a sequence of conductivities: a banded Cholesky factor L of the
/// stiffness, voltages from L^-1 P, the Jacobian from the fields L^-T L^-1 P. Holds the working
/// memory of one thread and allocates nothing after its construction.
class SheetOperator {
 public:
  /// The grid must fit the sensor (fits_grid). Throws InputError if an electrode falls between the
  /// nodes of the grid.
  explicit SheetOperator(const Sensor& sensor);

  Eigen::Index pixels() const { return Eigen::Index{columns_} * rows_; }
  Eigen::Index pairs() const { return static_cast<Eigen::Index>(drives_.size()); }

  /// `ratio` [pixels]: conductivity / background, > 0. The functions below use the last one set.
  void set_conductivity(const Eigen::VectorXd& ratio);
  /// Changes d' from the uniform sheet, V, of the pairs `kept` [kept].
  void changes(const std::vector<Eigen::Index>& kept, Eigen::VectorXd& out) const;
  /// Derivatives of d' with respect to the ratios, V [kept, pixels]; computes the fields.
  void jacobian(const std::vector<Eigen::Index>& kept, RowMajorMatrix& out);

 private:
  int columns_;
  int rows_;
  PixelEdges edges_;                                 ///< of the nodes
  std::vector<std::array<Eigen::Index, 2>> drives_;  ///< drive and measurement of each pair
  std::vector<double> scales_;  ///< sqrt(2) I / c0, V; without the root for single channels
  GridLaplacian stiffness_;
  Eigen::VectorXd weights_;                        ///< [edges of the nodes]
  RowMajorMatrix currents_;                        ///< P [nodes, pairs rounded up]
  RowMajorMatrix half_;                            ///< L^-1 P
  Eigen::MatrixXd products_;                       ///< P^T K^-1 P
  Eigen::MatrixXd uniform_;                        ///< products_ of the uniform sheet
  RowMajorMatrix fields_;                          ///< [drives rounded up, nodes]
  RowMajorMatrix along_rows_, along_columns_;      ///< differences of the fields [drives, edges]
  RowMajorMatrix row_products_, column_products_;  ///< products of two drives [edges]
};

}  // namespace ertbench
