#pragma once

#include "core/probe.h"

namespace ertbench {

/// The probe "limit": the best estimates of frames of one disc, by each of the samplers, with few
/// samples.
Probe limit_probe();

}  // namespace ertbench
