#include "core/wilson_interval.h"

#include <cmath>
#include <stdexcept>

namespace ertbench {

Interval wilson_interval(int count, int total) {
  if (total < 1 || count < 0 || count > total) {
    throw std::invalid_argument("wilson_interval: needs 0 <= count <= total, total >= 1");
  }
  constexpr double z = 1.959963984540054;  // normal quantile of 0.975
  const double n = total;
  const double share = count / n;
  const double middle = share + z * z / (2 * n);
  const double reach = z * std::sqrt(share * (1 - share) / n + z * z / (4 * n * n));
  const double stretch = 1 + z * z / n;
  // An end that is the share itself, 0 or 1, would be beyond it by rounding.
  return {count == 0 ? 0 : (middle - reach) / stretch,
          count == total ? 1 : (middle + reach) / stretch};
}

}  // namespace ertbench
