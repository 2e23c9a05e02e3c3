#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "forward/fem/forward_model.h"
#include "forward/sheet/sensor.h"
#include "solvers/channel_mask.h"
#include "solvers/total_variation/total_variation.h"

namespace ertbench::testing {

/// Total variation by its definition, on dense matrices, with two minimisers that share nothing
/// with the solver.
class DenseTotalVariation {
 public:
  /// Channels that use one of the `masked` electrodes see nothing.
  DenseTotalVariation(const Sensor& sensor, double alpha, ElectrodeSet masked = 0)
      : sensor_(sensor),
        jacobian_(ForwardModel(sensor, sensor.image_grid).jacobian()),
        edges_(Eigen::MatrixXd(PixelEdges(sensor.image_grid).count(), sensor.pixels())),
        alpha_(alpha) {
    const auto electrodes = electrodes_of_pairs(sensor);
    const auto pairs = reciprocal_pairs(sensor);
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (!(electrodes[p] & masked)) continue;
      for (const int channel : pairs[p]) jacobian_.row(channel).setZero();
    }
    const PixelEdges edges(sensor.image_grid);
    Eigen::VectorXd column(edges.count());
    for (Eigen::Index p = 0; p < edges.pixels(); ++p) {
      edges.differences(Eigen::VectorXd::Unit(edges.pixels(), p), column);
      edges_.col(p) = column * (2.0 / sensor.image_grid);
    }
  }

  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

  /// 1/2 |J x - d|^2 + alpha |A x|_1, less what no image can change: the differences between
  /// reciprocal channels.
  double objective(const Eigen::VectorXd& x, const Eigen::VectorXd& d) const {
    double fixed = 0;
    for (const auto& [p, q] : reciprocal_pairs(sensor_)) fixed += std::pow(d[p] - d[q], 2) / 4;
    return (jacobian_ * x - d).squaredNorm() / 2 - fixed + alpha_ * (edges_ * x).lpNorm<1>();
  }

  /// Alternating directions (Boyd et al. 2011) with residual balancing: slow and certain.
  Eigen::VectorXd admm(const Eigen::VectorXd& d, int iterations) const {
    const Eigen::MatrixXd jj = jacobian_.transpose() * jacobian_;
    const Eigen::MatrixXd aa = edges_.transpose() * edges_;
    const Eigen::VectorXd jd = jacobian_.transpose() * d;
    double rho = jj.trace() / aa.trace();
    Eigen::LLT<Eigen::MatrixXd> factor(jj + rho * aa);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(jd.size());
    Eigen::VectorXd z = Eigen::VectorXd::Zero(edges_.rows());
    Eigen::VectorXd u = z;
    Eigen::VectorXd best = x;
    for (int i = 0; i < iterations; ++i) {
      x = factor.solve(jd + rho * edges_.transpose() * (z - u));
      const Eigen::VectorXd t = edges_ * x;
      const Eigen::VectorXd before = z;
      z = (t + u).unaryExpr(
          [&](double v) { return std::copysign(std::max(std::abs(v) - alpha_ / rho, 0.0), v); });
      u += t - z;
      if (i % 10 == 9) {
        if (objective(x, d) < objective(best, d)) best = x;
        const double primal = (t - z).norm() / (1e-300 + std::max(t.norm(), z.norm()));
        const double dual =
            (edges_.transpose() * (z - before)).norm() / (1e-300 + (edges_.transpose() * u).norm());
        const double change = primal > 5 * dual ? 2 : dual > 5 * primal ? 0.5 : 1;
        if (change != 1 && i < iterations / 2) {
          rho *= change;
          u /= change;
          factor.compute(jj + rho * aa);
        }
      }
    }
    return best;
  }

  /// The primal-dual iteration of EIDORS's inv_solve_TV_pdipm (Borsic, Graham, Adler and Lionheart,
  /// IEEE Trans. Med. Imaging 29, 2010): |t| smoothed to sqrt(t^2 + beta), beta falling by a factor
  /// that falls itself; a line search over eight lengths; a fixed number of steps.
  Eigen::VectorXd borsic(const Eigen::VectorXd& d, int steps) const {
    const Eigen::MatrixXd jj = jacobian_.transpose() * jacobian_;
    const Eigen::MatrixXd aa = edges_.transpose() * edges_;
    Eigen::VectorXd x = (jj + 1e-4 * aa).llt().solve(jacobian_.transpose() * d);
    Eigen::ArrayXd y = Eigen::ArrayXd::Zero(edges_.rows());
    double beta = 1e-4;
    double decay = 0.7;
    for (int k = 0; k < steps; ++k) {
      const Eigen::ArrayXd t = edges_ * x;
      const Eigen::ArrayXd smooth = (t.square() + beta).sqrt();
      const Eigen::ArrayXd weight = (1 - y * t / smooth) / smooth;
      const Eigen::VectorXd gradient = jacobian_.transpose() * (jacobian_ * x - d) +
                                       alpha_ * (edges_.transpose() * (t / smooth).matrix());
      const Eigen::MatrixXd hessian =
          jj + alpha_ * (edges_.transpose() * weight.matrix().asDiagonal() * edges_);
      const Eigen::VectorXd dx = -hessian.ldlt().solve(gradient);
      const Eigen::ArrayXd dy = -y + t / smooth + weight * (edges_ * dx).array();
      double best = 0;
      for (const double length : {1e-4, 1e-3, 1e-2, 0.1, 0.2, 0.5, 0.8, 1.0}) {
        if (objective(x + length * dx, d) < objective(x + best * dx, d)) best = length;
      }
      x += best * dx;
      const Eigen::ArrayXd room =
          (dy.sign() - y) / dy.unaryExpr([](double v) { return v == 0 ? 1e-6 : v; });
      y += std::min(1.0, 0.99 * room.minCoeff()) * dy;
      beta = std::max(beta * decay, 1e-12);
      decay *= 0.8;
    }
    return x;
  }

 private:
  Sensor sensor_;
  Eigen::MatrixXd jacobian_;
  Eigen::MatrixXd edges_;
  double alpha_;
};

}  // namespace ertbench::testing
