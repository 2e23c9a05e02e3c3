#include "bench/studies/error_statistics.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "core/bootstrap.h"
#include "core/text.h"

namespace ertbench {

std::optional<double> value_of(const std::optional<Estimate>& estimate) {
  return estimate ? std::optional(estimate->value) : std::nullopt;
}

nlohmann::json to_json(const std::optional<Estimate>& estimate) {
  if (!estimate) return nullptr;
  return {{"value", estimate->value}, {"ci95", {estimate->ci95.low, estimate->ci95.high}}};
}

Cell estimate_cell(const std::optional<Estimate>& estimate, int decimals) {
  if (!estimate) return number_cell(std::nullopt, decimals);
  Cell cell = number_cell(estimate->value, decimals);
  cell.interval =
      interval_text(fixed(estimate->ci95.low, decimals), fixed(estimate->ci95.high, decimals));
  return cell;
}

GroupedErrors GroupedErrors::compact() const {
  std::vector<std::size_t> place(groups_, 0);
  for (const Value& value : values_) place[value.group] = 1;
  std::size_t count = 0;
  for (std::size_t& one : place) one = one > 0 ? count++ : 0;
  GroupedErrors out(count);
  for (const Value& value : values_) out.add(place[value.group], value.error);
  return out;
}

std::optional<Estimate> GroupedErrors::mean(std::string_view name) const {
  if (values_.empty()) return std::nullopt;
  return compact().mean_of_groups(name);
}

std::optional<Estimate> GroupedErrors::quantile(double share, std::string_view name) const {
  if (values_.empty()) return std::nullopt;
  return compact().quantile_of_groups(share, name);
}

Estimate GroupedErrors::mean_of_groups(std::string_view name) const {
  std::vector<double> sums(groups_, 0);
  std::vector<double> counts(groups_, 0);
  for (const Value& value : values_) {
    sums[value.group] += value.error;
    counts[value.group] += 1;
  }
  const std::optional<RatioOfSums> mean = ratio_of_sums(sums, counts, name);
  return {mean->ratio, mean->ci95};
}

Estimate GroupedErrors::quantile_of_groups(double share, std::string_view name) const {
  std::vector<Value> sorted = values_;
  std::sort(sorted.begin(), sorted.end(),
            [](const Value& a, const Value& b) { return a.error < b.error; });
  std::vector<double> counts(groups_, 0);
  for (const Value& value : sorted) counts[value.group] += 1;
  // A group that was drawn several times counts as often; the errors stay sorted.
  std::vector<double> weights(groups_);
  const auto quantile_of = [&](std::span<const std::size_t> drawn) {
    std::fill(weights.begin(), weights.end(), 0);
    double total = 0;
    for (const std::size_t group : drawn) {
      weights[group] += 1;
      total += counts[group];
    }
    double passed = 0;
    for (const Value& value : sorted) {
      passed += weights[value.group];
      if (passed >= share * total * (1 - 1e-12) && passed > 0) return value.error;
    }
    return sorted.back().error;
  };
  std::vector<std::size_t> all(groups_);
  for (std::size_t g = 0; g < groups_; ++g) all[g] = g;
  return Estimate{quantile_of(all), bootstrap_interval_of_groups(groups_, quantile_of, name)};
}

std::optional<double> GroupedErrors::worst() const {
  if (values_.empty()) return std::nullopt;
  return std::max_element(values_.begin(), values_.end(),
                          [](const Value& a, const Value& b) { return a.error < b.error; })
      ->error;
}

}  // namespace ertbench
