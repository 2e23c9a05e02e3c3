#include "bench/contacts/ospa.h"

#include <algorithm>

#include "bench/contacts/assignment.h"

namespace ertbench {

double ospa(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, double cutoff) {
  const std::size_t fewer = std::min(a.size(), b.size());
  const std::size_t more = std::max(a.size(), b.size());
  if (more == 0) return 0;
  const double alone = cutoff * static_cast<double>(more - fewer);
  return (assign(distances_between(a, b), cutoff).cost + alone) / static_cast<double>(more);
}

}  // namespace ertbench
