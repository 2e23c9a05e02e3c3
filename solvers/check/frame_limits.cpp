#include "solvers/check/frame_limits.h"

#include <algorithm>
#include <cmath>

#include "solvers/symmetric_eigen.h"

namespace ertbench {

double tail_limit(Eigen::VectorXd values, double share) {
  std::sort(values.begin(), values.end(), std::greater<>());
  const Eigen::Index farthest = std::max<Eigen::Index>(values.size() / 10, 1);
  if (values.size() <= farthest || values[farthest] <= 0) return values[0];
  const double begin = values[farthest];
  const double seen = values[static_cast<Eigen::Index>(share * static_cast<double>(values.size()))];
  const Eigen::ArrayXd logarithms = (values.head(farthest).array() / begin).log();
  const double first = logarithms.mean();
  const double second = logarithms.square().mean();
  if (!(second > first * first)) return values[0];
  const double bounded = std::min(0.0, 1 - 0.5 / (1 - first * first / second));
  const double exponent = first + bounded;
  const double farther =
      std::log(static_cast<double>(farthest) / static_cast<double>(values.size()) / share);
  // (farther^exponent - 1) / exponent, which is a logarithm where the exponent is 0.
  const double reach =
      std::abs(exponent) < 1e-9 ? farther : std::expm1(exponent * farther) / exponent;
  return std::max(begin * (1 + first * (1 - bounded) * reach), seen);
}

UsualLevel UsualLevel::of(const Eigen::VectorXd& q, const Eigen::VectorXd& s, double floor,
                          double share) {
  // Least squares with relative errors: the weights follow from the level found before.
  UsualLevel level{std::max(q.mean(), floor), 0, 0};
  for (int i = 0; i < 10; ++i) {
    const Eigen::ArrayXd w = (level.a + level.b * s.array()).square().inverse();
    const double ww = w.sum();
    const double ws = (w * s.array()).sum();
    const double wss = (w * s.array().square()).sum();
    const double wq = (w * q.array()).sum();
    const double wqs = (w * q.array() * s.array()).sum();
    const double determinant = ww * wss - ws * ws;
    level.b = determinant > 1e-12 * ww * wss ? (ww * wqs - ws * wq) / determinant : 0;
    level.b = std::max(level.b, 0.0);
    level.a = (wq - level.b * ws) / ww;
    if (level.a < floor) {
      level.a = floor;
      level.b = wss > 0 ? std::max(0.0, (wqs - floor * ws) / wss) : 0;
    }
  }
  level.limit = tail_limit((q.array() / (level.a + level.b * s.array())).matrix(), share);
  // A level below the floor is none: what a converter does not resolve raises no alarm.
  level.limit = std::max(level.limit, 1.0);
  return level;
}

PrincipalDirections PrincipalDirections::of(const Eigen::MatrixXd& frames, double noise) {
  PrincipalDirections out;
  out.mean = frames.colwise().mean().transpose();
  const Eigen::MatrixXd centred = frames.rowwise() - out.mean.transpose();
  const SymmetricEigen eigen =
      symmetric_eigen(centred.transpose() * centred / static_cast<double>(frames.rows() - 1));
  const auto above = (eigen.values.array() >= 2 * noise).count();
  const Eigen::Index count = std::min({above, most, frames.rows() / 4});
  out.rows = eigen.vectors.rightCols(count).transpose();
  out.inverse_power = eigen.values.tail(count).cwiseInverse();
  out.tilt = out.inverse_power.cwiseProduct(out.rows * out.mean);
  return out;
}

}  // namespace ertbench
