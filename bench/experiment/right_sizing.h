#pragma once

#include "bench/score/metrics.h"

namespace ertbench {

/// "right_sizing" of an experiment: of each family of settings the smallest that is good enough on
/// the validation set. A family's settings are listed from the smallest to the largest.
struct RightSizing {
  double margin = 0.05;  ///< how far an error may lie above the family's least, as a part of that
  Metric metric = Metric::relative_error;
};

}  // namespace ertbench
