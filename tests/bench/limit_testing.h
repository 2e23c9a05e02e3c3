#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace ertbench::testing {

/// Distance of Kolmogorov and Smirnov between values and a uniform distribution over 0 ... 1.
inline double distance_from_uniform(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double most = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    most = std::max(most, std::abs(values[i] - (static_cast<double>(i) + 0.5) /
                                                   static_cast<double>(values.size())));
  }
  return most;
}

}  // namespace ertbench::testing
