#pragma once

#include "bench/experiment/chart_type.h"

namespace ertbench {

/// All charts that an experiment can ask for.
ChartTypes chart_types();

}  // namespace ertbench
