#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// Electrodes, counted from 0, nearly all (four fifths) of whose channels are bad; `is_bad` is
/// asked for each channel.
std::vector<int> electrodes_with_bad_channels(const Sensor& sensor,
                                              const std::function<bool(Eigen::Index)>& is_bad);

/// Those whose channels are under a tenth of `expected`
/// [channels], in absolute values.
std::vector<int> electrodes_reading_zero(const Sensor& sensor, const Eigen::VectorXd& reference,
                                         const Eigen::VectorXd& expected);

}  // namespace ertbench
