#pragma once

namespace ertbench {

/// A 95 % interval of a statistic.
struct Interval {
  double low = 0;
  double high = 0;

  bool operator==(const Interval&) const = default;
};

}  // namespace ertbench
