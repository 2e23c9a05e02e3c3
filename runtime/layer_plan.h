#pragma once

#include <memory>

#include "core/layers.h"
#include "models/inference/inference_plan.h"

namespace ertbench::runtime {

/// The layers of a list in the order of their kernels. Throws std::runtime_error for layers whose
/// sizes do not fit together, or that do not lead from `inputs` numbers to `outputs`.
std::unique_ptr<InferencePlan> plan_of(const LayerList& list, int inputs, int outputs);

}  // namespace ertbench::runtime
