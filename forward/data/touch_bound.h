#pragma once

#include <Eigen/Core>

#include "forward/data/dataset_spec.h"

namespace ertbench {

class SceneModel;

/// The Cramér-Rao bound of one touch at rest whose indenter is known: the least covariance that any
/// unbiased estimate of (x mm, y mm, force N) can have from one frame of the set's noise, (J^T
/// J)^-1 s^2 with J the derivatives of the voltages and s the noise of a channel.
///
/// The derivatives are central differences of the forward model over 0.1 mm and a hundredth of the
/// force. `model` has the spec's sensor and SheetModel; the spec has noise. The faults of the sheet
/// are left out.
Eigen::Matrix3d touch_bound(const DatasetSpec& spec, const SceneModel& model, const Touch& touch);

/// Noise of one channel on a frame of these clean voltages, V.
double channel_noise(const DatasetSpec& spec, const SceneModel& model,
                     const Eigen::Ref<const Eigen::VectorXd>& frame);

}  // namespace ertbench
