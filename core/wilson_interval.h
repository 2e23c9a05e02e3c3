#pragma once

#include "core/interval.h"

namespace ertbench {

/// Wilson's 95 % score interval of a share of which `count` in `total` independent trials were
/// seen (Wilson 1927; Newcombe 1998, method 3): unlike the usual one it is right for shares near 0
/// and 1 too. Throws std::invalid_argument unless 0 <= count <= total and total >= 1.
Interval wilson_interval(int count, int total);

}  // namespace ertbench
