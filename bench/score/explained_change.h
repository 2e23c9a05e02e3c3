#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// How much of a measured change of the voltages an image explains: what its linear response on the
/// uniform sheet, at the best amplitude and with the level of the whole sheet free, leaves of the
/// change's norm. Needs no truth, and is the same for every method.
class ExplainedChange {
 public:
  /// `reference` [channels] V, which a change of the sheet's level multiplies.
  ExplainedChange(const Sensor& sensor, const Eigen::VectorXd& reference);

  /// 1 - min over a, b of |change - a J image - b reference| / |change|, 0 ... 1. `change`
  /// [channels] V, `image` [pixels] S/m, all finite. Nothing where the change is zero.
  std::optional<double> of(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           const Eigen::Ref<const Eigen::RowVectorXd>& image) const;

 private:
  RowMajorMatrix jacobian_;  ///< [channels, pixels]
  Eigen::VectorXd reference_;
};

}  // namespace ertbench
