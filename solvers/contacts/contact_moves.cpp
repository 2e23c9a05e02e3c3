#include "solvers/contacts/contact_moves.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

/// The longest step of each parameter.
EllipticContact::Vector step_limits() {
  EllipticContact::Vector out;
  out << 0.25, 0.25, 0.6, 0.3, 0.3, 1.2;
  return out;
}

}  // namespace

double step_share(const Eigen::VectorXd& step) {
  const EllipticContact::Vector limits = step_limits();
  double longest = 1;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    longest = std::max(longest, std::abs(step[i]) / limits[i % EllipticContact::parameters]);
  }
  return 1 / longest;
}

std::vector<EllipticContact> moved(std::span<const EllipticContact> contacts,
                                   const Eigen::VectorXd& step) {
  const double share = step_share(step);
  std::vector<EllipticContact> out;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    out.push_back(EllipticContact::from(
        contacts[k].vector() +
        share * step.segment<EllipticContact::parameters>(EllipticContact::parameters *
                                                          static_cast<Eigen::Index>(k))));
  }
  return out;
}

EllipticContact joined(const EllipticContact& a, const EllipticContact& b) {
  const double share = a.area() / (a.area() + b.area());
  EllipticContact out;
  out.centre = share * a.centre + (1 - share) * b.centre;
  const auto moments = [&](const EllipticContact& c) {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(c.angle()).toRotationMatrix();
    const Eigen::Vector2d squares = c.half_axes().cwiseAbs2() / 4;
    const Eigen::Vector2d d = c.centre - out.centre;
    return Eigen::Matrix2d(turn * squares.asDiagonal() * turn.transpose() + d * d.transpose());
  };
  const Eigen::Matrix2d second = share * moments(a) + (1 - share) * moments(b);
  // exp(2 M) = 4 second.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(4 * second);
  const Eigen::Vector2d logs = axes.eigenvalues().array().log() / 2;
  const Eigen::Matrix2d m =
      axes.eigenvectors() * logs.asDiagonal() * axes.eigenvectors().transpose();
  out.log_size = m.trace() / 2;
  out.stretch = {(m(0, 0) - m(1, 1)) / 2, m(0, 1)};
  out.log_ratio = share * a.log_ratio + (1 - share) * b.log_ratio;
  return out;
}

std::vector<EllipticContact> with_split(std::span<const EllipticContact> contacts, std::size_t k) {
  std::vector<EllipticContact> out(contacts.begin(), contacts.end());
  const Eigen::Vector2d axes = contacts[k].half_axes();
  const double angle = contacts[k].angle();
  const Eigen::Vector2d step = 0.55 * axes.x() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  EllipticContact part = contacts[k];
  part.stretch.setZero();
  part.log_size = std::log(std::min(0.45 * axes.x(), axes.y()));
  part.centre = contacts[k].centre + step;
  out[k] = part;
  part.centre = contacts[k].centre - step;
  out.push_back(part);
  return out;
}

}  // namespace ertbench
