#include "bench/contacts/constant_velocity.h"

namespace ertbench {

ConstantVelocity::ConstantVelocity(const Eigen::Vector2d& place_mm, double place_deviation_mm,
                                   double speed_deviation_mm_s)
    : state_(Eigen::Matrix2d::Zero()),
      covariance_(Eigen::Vector2d(place_deviation_mm, speed_deviation_mm_s)
                      .cwiseAbs2()
                      .asDiagonal()
                      .toDenseMatrix()) {
  state_.row(0) = place_mm;
}

void ConstantVelocity::predict(double step_s, double acceleration_deviation_mm_s2) {
  Eigen::Matrix2d motion = Eigen::Matrix2d::Identity();
  motion(0, 1) = step_s;
  const Eigen::Vector2d push =
      acceleration_deviation_mm_s2 * Eigen::Vector2d(step_s * step_s / 2, step_s);
  state_ = motion * state_;
  covariance_ = motion * covariance_ * motion.transpose() + push * push.transpose();
}

void ConstantVelocity::update(const Eigen::Vector2d& place_mm, double ago_s,
                              double place_deviation_mm) {
  const Eigen::RowVector2d observation(1, -ago_s);
  const double variance = place_deviation_mm * place_deviation_mm;
  const Eigen::Vector2d gain = covariance_ * observation.transpose() /
                               (observation * covariance_ * observation.transpose() + variance);
  state_ += gain * (place_mm.transpose() - observation * state_);
  // Joseph's form: symmetric and positive whatever the rounding.
  const Eigen::Matrix2d kept = Eigen::Matrix2d::Identity() - gain * observation;
  covariance_ = kept * covariance_ * kept.transpose() + variance * gain * gain.transpose();
}

}  // namespace ertbench
