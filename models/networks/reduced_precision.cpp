#include "models/networks/reduced_precision.h"

#include <ATen/autocast_mode.h>

namespace ertbench {

ReducedPrecision::ReducedPrecision(bool enabled) : enabled_(enabled) {
  if (!enabled_) return;
  at::autocast::set_autocast_cpu_dtype(at::kBFloat16);
  at::autocast::set_cpu_enabled(true);
}

ReducedPrecision::~ReducedPrecision() {
  if (!enabled_) return;
  at::autocast::clear_cache();  // weights that were rounded; the next step changes them
  at::autocast::set_cpu_enabled(false);
}

}  // namespace ertbench
