#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// Gives an entry of `contacts` what it would take from a validation set: the noise of the frames
/// without contact, over the root mean square of their mean, at the model's level, and the prior as
/// it is. A measured reference [channels] V lies away from the model's: this is the model error,
/// and level, gradient and electrodes are unknowns, too. Other entries stay as they are.
void complete_contacts(nlohmann::json& entry, const Sensor& sensor,
                       const Eigen::VectorXd& reference, double relative_noise);

}  // namespace ertbench
