#include "bench/check/noticeable.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace ertbench {
namespace {

std::string with_digits(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

std::optional<double> Noticeable::share() const {
  const MetricEntry& entry = entry_of(metric);
  const bool error = entry.better == Better::smaller && centre != 0;
  return error ? std::optional(amount / std::abs(centre)) : std::nullopt;
}

std::optional<double> Noticeable::part_of_limit() const {
  for (const NoticeLimit& limit : kNoticeLimits) {
    if (limit.metric != metric || (limit.of_value && centre == 0)) continue;
    return amount / (limit.most * (limit.of_value ? std::abs(centre) : 1.0));
  }
  return std::nullopt;
}

std::vector<Noticeable> noticeable_worsenings(const Baseline& baseline, const Sensor& sensor,
                                              int trainings) {
  std::vector<Noticeable> out;
  for (const BaselineRow& row : baseline.rows) {
    for (const Metric metric : baseline.metrics) {
      const std::vector<double>& values = row.metrics[metric];
      if (values.empty()) continue;
      out.push_back({row.label, row.dataset, metric, row.tolerance.type, centre_of(values),
                     allowed_change(row.tolerance, mean_of(row, metric, sensor), trainings)});
    }
  }
  return out;
}

std::vector<Noticeable> beyond_limits(std::span<const Noticeable> all) {
  std::vector<Noticeable> out;
  std::copy_if(all.begin(), all.end(), std::back_inserter(out), [](const Noticeable& one) {
    return one.type == ToleranceClass::seeds && one.part_of_limit().value_or(0) > 1;
  });
  return out;
}

std::optional<int> seeds_that_would_do(std::span<const Noticeable> coarse, int seeds, int trainings,
                                       int most) {
  double beyond = 1;
  for (const Noticeable& one : coarse) beyond = std::max(beyond, one.part_of_limit().value_or(0));
  const double wanted = seeds_interval(seeds, trainings) / beyond;
  for (int n = seeds; n <= most; ++n) {
    if (seeds_interval(n, trainings) <= wanted) return n;
  }
  return std::nullopt;
}

std::string text_of(const Noticeable& one) {
  const std::string amount = with_digits("%.2g", one.amount);
  const std::optional<double> share = one.share();
  return share ? amount + with_digits(" (%.2g %%)", 100 * *share) : amount;
}

std::string weakest_text(std::span<const Noticeable> all) {
  const auto weakest =
      std::max_element(all.begin(), all.end(), [](const Noticeable& a, const Noticeable& b) {
        return a.part_of_limit().value_or(-1) < b.part_of_limit().value_or(-1);
      });
  if (weakest == all.end() || !weakest->part_of_limit()) return "";
  return "weakest: " + weakest->row + " " + name_of(weakest->metric) + ", noticed from " +
         text_of(*weakest);
}

}  // namespace ertbench
