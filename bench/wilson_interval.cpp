#include "bench/wilson_interval.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ertbench {

ShareInterval wilson_interval(int count, int total) {
  if (total < 1 || count < 0 || count > total) {
    throw std::invalid_argument("wilson_interval: needs 0 <= count <= total, total >= 1");
  }
  constexpr double z = 1.959963984540054;  // normal quantile of 0.975
  const double n = total;
  const double share = count / n;
  const double middle = share + z * z / (2 * n);
  const double reach = z * std::sqrt(share * (1 - share) / n + z * z / (4 * n * n));
  const double stretch = 1 + z * z / n;
  return {std::max(0.0, (middle - reach) / stretch), std::min(1.0, (middle + reach) / stretch)};
}

}  // namespace ertbench
