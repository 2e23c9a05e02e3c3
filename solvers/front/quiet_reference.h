#pragma once

#include <Eigen/Core>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// Follows a reference that ages: takes level and gradient of the untouched sheet out of frames,
/// learned while nothing presses.
///
/// The mean of the frames of a second is quiet if level and gradients explain it to its noise.
/// After two such seconds they are taken out of all later frames. While something presses no second
/// is quiet, however long it lasts, so that a constant press is never learned: what is learned lies
/// along the three responses, and a press leaves a rest beside them. A touch so faint that its rest
/// drowns in the noise of a second may lose what it shares with them.
class QuietReference {
 public:
  explicit QuietReference(const Sensor& sensor);

  /// Takes the drift known so far out of a frame's change [channels] V from the reference, and
  /// learns from it. `time_s` rises.
  void follow(Eigen::Ref<Eigen::RowVectorXd> change, double time_s);
  const Eigen::RowVectorXd& drift() const { return drift_; }  ///< [channels] V

 private:
  void end_window();

  Eigen::MatrixXd responses_;  ///< [channels, 3] orthonormal
  Eigen::RowVectorXd drift_;
  Eigen::RowVectorXd sum_;  ///< of the window's frames
  double squares_ = 0;      ///< of all their numbers
  int frames_ = 0;
  double begin_s_ = 0;
  double least_noise_ = 0;  ///< variance of a channel, the least of all windows; 0: none yet
  int quiet_windows_ = 0;
};

}  // namespace ertbench
