#pragma once

#include <Eigen/Core>

namespace ertbench {

/// Kalman filter of a point that moves with constant velocity but for a random acceleration, which
/// is independent from each step to the next and constant within it. The noise is the same in all
/// directions, so that x and y have one covariance and one gain. Lengths in mm, times in s.
class ConstantVelocity {
 public:
  /// At a measured place, of a velocity that is 0 but for the standard deviations.
  ConstantVelocity(const Eigen::Vector2d& place_mm, double place_deviation_mm,
                   double speed_deviation_mm_s);

  /// Goes on by `step_s` under an acceleration of this standard deviation along each axis.
  void predict(double step_s, double acceleration_deviation_mm_s2);

  /// Takes in where the point was `ago_s` before the present time, measured with this standard
  /// deviation along each axis.
  void update(const Eigen::Vector2d& place_mm, double ago_s, double place_deviation_mm);

  Eigen::Vector2d place_mm() const { return state_.row(0); }
  Eigen::Vector2d velocity_mm_s() const { return state_.row(1); }
  /// Of (place, velocity) along either axis: mm^2, mm^2/s, mm^2/s^2.
  const Eigen::Matrix2d& covariance() const { return covariance_; }

 private:
  Eigen::Matrix2d state_;  ///< (place, velocity) of x in the first column, of y in the second
  Eigen::Matrix2d covariance_;
};

}  // namespace ertbench
