#pragma once

#include <Eigen/Core>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The changes of voltages that contacts can make: the leading left singular vectors, those above a
/// hundredth of the first, of the changes by small discs all over the sheet. A dozen or two of
/// directions out of all channels, so that frames whose channels stand in another order hardly fit.
class ContactSpan {
 public:
  explicit ContactSpan(const Sensor& sensor);

  Eigen::Index directions() const { return basis_.cols(); }
  /// The part of the squares of `changes` [frames, channels] that lies in the span, 0 ... 1.
  double share(const Frames& changes) const;

 private:
  Eigen::MatrixXd basis_;  ///< [channels, directions], orthonormal
};

}  // namespace ertbench
