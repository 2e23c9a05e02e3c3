#pragma once

#include "forward/sheet/skin.h"

namespace ertbench {

/// Conductivity of the sheet below a patch over the background's, at a mean pressure `kPa` >= 0 on
/// the patch: 1 at none, strictly monotone (see FallingLaw, RisingLaw).
double conductivity_ratio(const ContactLaw& law, double kPa);

/// Its derivative, 1/kPa.
double conductivity_ratio_slope(const ContactLaw& law, double kPa);

}  // namespace ertbench
