#pragma once

#include "core/probe.h"

namespace ertbench {

/// The probe "scores": metrics of fixed images, their summaries, and the contacts that are read out
/// of the images.
Probe score_probe();

}  // namespace ertbench
