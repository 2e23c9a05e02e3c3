#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace ertbench {

/// From the least value to the largest; empty before the first.
struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

/// Values to stand at a logarithmic axis: in even steps over a narrow range, 1, 2, 5, 10, ... over
/// a few decades, powers of ten over many. The span must be positive.
std::vector<double> log_ticks(const Span& span);

/// The ticks as gnuplot's `set xtics (...)` takes them.
std::string tick_list(const std::vector<double>& ticks);

}  // namespace ertbench
