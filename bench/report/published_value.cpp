#include "bench/report/published_value.h"

#include <algorithm>

namespace ertbench {

std::optional<double> published_value(const PublishedTable& published, const ResultRow& row,
                                      Metric metric) {
  const auto& sets = published.datasets;
  if (!sets.empty() && std::find(sets.begin(), sets.end(), row.dataset) == sets.end()) {
    return std::nullopt;
  }
  for (const PublishedRow& candidate : published.rows) {
    if (candidate.label == row.label) return candidate.values[metric];
  }
  return std::nullopt;
}

}  // namespace ertbench
