#include "bench/studies/error_statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "core/lists.h"
#include "core/text.h"

namespace ertbench {

Estimate Estimate::exact(double value) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  return {value, {none, none}};
}

std::optional<double> value_of(const std::optional<Estimate>& estimate) {
  return estimate ? std::optional(estimate->value) : std::nullopt;
}

std::optional<Estimate> scaled(std::optional<Estimate> estimate, double factor) {
  if (estimate) {
    estimate->value *= factor;
    estimate->ci95 = {factor * estimate->ci95.low, factor * estimate->ci95.high};
  }
  return estimate;
}

nlohmann::json to_json(const std::optional<Estimate>& estimate, const char* key) {
  if (!estimate) return nullptr;
  return {{key, estimate->value}, {"ci95", {estimate->ci95.low, estimate->ci95.high}}};
}

nlohmann::json to_json(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

Cell estimate_cell(const std::optional<Estimate>& estimate, int decimals) {
  if (!estimate) return number_cell(std::nullopt, decimals);
  Cell cell = number_cell(estimate->value, decimals);
  if (std::isnan(estimate->ci95.low)) return cell;
  cell.interval =
      interval_text(fixed(estimate->ci95.low, decimals), fixed(estimate->ci95.high, decimals));
  return cell;
}

std::vector<Cell> exact_cells(const std::optional<Estimate>& estimate) {
  if (!estimate) return std::vector<Cell>(3);
  return {exact_cell(estimate->value), exact_cell(estimate->ci95.low),
          exact_cell(estimate->ci95.high)};
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
  const GroupedErrors own = compact();
  std::vector<double> sums(own.groups_, 0);
  std::vector<double> counts(own.groups_, 0);
  for (const Value& value : own.values_) {
    sums[value.group] += value.error;
    counts[value.group] += 1;
  }
  const std::optional<RatioOfSums> mean = ratio_of_sums(sums, counts, name);
  return Estimate{mean->ratio, mean->ci95};
}

std::optional<Estimate> GroupedErrors::quantile(double share, std::string_view name) const {
  if (values_.empty()) return std::nullopt;
  GroupedErrors own = compact();
  std::vector<Value>& sorted = own.values_;
  std::ranges::sort(sorted, {}, &Value::error);
  std::vector<double> counts(own.groups_, 0);
  for (const Value& value : sorted) counts[value.group] += 1;
  // A group that was drawn several times counts as often; the errors stay sorted.
  std::vector<double> weights(own.groups_);
  const auto quantile_of = [&](std::span<const std::size_t> drawn) {
    std::ranges::fill(weights, 0);
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
  std::vector<std::size_t> all(own.groups_);
  std::iota(all.begin(), all.end(), 0);
  return Estimate{quantile_of(all), bootstrap_interval_of_groups(own.groups_, quantile_of, name)};
}

std::optional<double> GroupedErrors::worst() const {
  if (values_.empty()) return std::nullopt;
  return std::ranges::max(values_, {}, &Value::error).error;
}

namespace {

constexpr double isotonic_bin = 20;  ///< trials

/// Trials as regression takes them: weight, mean value and share of successes.
struct PooledTrials {
  double weight = 0;
  double value = 0;    ///< sum
  double success = 0;  ///< sum

  double mean() const { return value / weight; }
  double share() const { return success / weight; }
  void add(const PooledTrials& other) {
    weight += other.weight;
    value += other.value;
    success += other.success;
  }
};

/// The value at which the isotonic fit reaches the share; `nowhere` where it never does. `trials`
/// ascend and weigh what their groups do.
double isotonic_crossing(std::span<const Trial> trials, std::span<const double> weights,
                         double share, double nowhere) {
  std::vector<PooledTrials> bins;
  PooledTrials bin;
  for (const Trial& trial : trials) {
    const double weight = weights[trial.group];
    if (weight == 0) continue;
    bin.add({weight, weight * trial.value, trial.success ? weight : 0});
    if (bin.weight < isotonic_bin) continue;
    bins.push_back(bin);
    bin = {};
  }
  if (bin.weight > 0 && !bins.empty()) bins.back().add(bin);
  if (bins.empty()) return nowhere;

  // The share fitted to each bin is that of the block of bins that it ends up in.
  struct Block {
    PooledTrials sum;
    std::size_t first;
  };
  std::vector<Block> blocks;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    blocks.push_back({bins[b], b});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].sum.share() > blocks.back().sum.share()) {
      blocks[blocks.size() - 2].sum.add(blocks.back().sum);
      blocks.pop_back();
    }
  }
  const auto reached =
      std::ranges::find_if(blocks, [&](const Block& block) { return block.sum.share() >= share; });
  if (reached == blocks.end()) return nowhere;
  const double right = bins[reached->first].mean();
  if (reached == blocks.begin()) return right;
  const double below = std::prev(reached)->sum.share();
  const double left = bins[reached->first - 1].mean();
  return left + (right - left) * (share - below) / (reached->sum.share() - below);
}

/// The column or row of a share of the sheet's width or height.
int area_slot(double share, int areas) {
  return static_cast<int>(std::clamp(std::floor(share * areas), 0.0, areas - 1.0));
}

/// The middle of an area, domain units from the middle of the bounds.
Eigen::Vector2d middle_of_area(const Sheet& sheet, int area, int areas) {
  const Eigen::Vector2d share((area % areas + 0.5) / areas - 0.5,
                              (area / areas + 0.5) / areas - 0.5);
  return share.cwiseProduct(sheet.bounds().sizes());
}

}  // namespace

std::vector<IsotonicBlock> isotonic_fit(std::span<const WeightedPoint> points) {
  std::vector<IsotonicBlock> blocks;
  // The last block takes in the one behind it.
  const auto pool = [&](const IsotonicBlock& next) {
    IsotonicBlock& block = blocks.back();
    const double weight = block.weight + next.weight;
    block.value = (block.weight * block.value + next.weight * next.value) / weight;
    block.weight = weight;
    block.last = next.last;
  };
  const auto settle = [&] {
    while (blocks.size() > 1 && blocks[blocks.size() - 2].value >= blocks.back().value) {
      const IsotonicBlock violator = blocks.back();
      blocks.pop_back();
      pool(violator);
    }
  };
  std::optional<IsotonicBlock> same;  // all points of one x
  const auto push_same = [&] {
    if (!same) return;
    blocks.push_back(*same);
    settle();
  };
  for (const WeightedPoint& point : points) {
    if (point.weight <= 0) continue;
    if (same && same->first == point.x) {
      const double weight = same->weight + point.weight;
      same->value = (same->weight * same->value + point.weight * point.y) / weight;
      same->weight = weight;
      continue;
    }
    push_same();
    same = IsotonicBlock{point.x, point.x, point.y, point.weight};
  }
  push_same();
  return blocks;
}

std::optional<Estimate> CountedShare::share() const {
  if (total == 0) return std::nullopt;
  return Estimate{count / static_cast<double>(total), wilson_interval(count, total)};
}

std::vector<ShareBin> share_bins(std::vector<Trial> trials, int bins) {
  std::ranges::stable_sort(trials, {}, &Trial::value);
  const std::size_t most = trials.size() / static_cast<std::size_t>(isotonic_bin);
  const std::size_t count =
      std::max<std::size_t>(std::min(static_cast<std::size_t>(bins), most), 1);
  std::vector<ShareBin> out;
  for (std::size_t b = 0; b < count && !trials.empty(); ++b) {
    const std::size_t first = b * trials.size() / count;
    const std::size_t end = (b + 1) * trials.size() / count;
    ShareBin& bin = out.emplace_back(ShareBin{trials[first].value, trials[end - 1].value, {}});
    for (std::size_t t = first; t < end; ++t) bin.successes.add(trials[t].success);
  }
  return out;
}

std::optional<LeastFound> least_found(std::vector<Trial> trials, double share,
                                      const std::string& name) {
  if (static_cast<double>(trials.size()) < 2 * isotonic_bin) return std::nullopt;
  std::ranges::stable_sort(trials, {}, &Trial::value);
  LeastFound out;
  for (std::size_t t = 0; t < static_cast<std::size_t>(isotonic_bin); ++t) {
    out.reach.low += trials[t].value;
  }
  out.reach.low /= isotonic_bin;  // rounded as the mean of a bin is
  out.reach.high = trials.back().value;
  const double nowhere = out.reach.high + std::max(out.reach.high - out.reach.low, 1e-9);

  // Groups are numbered anew, so that only those that have trials here are drawn.
  std::vector<std::size_t> groups;
  for (const Trial& trial : trials) groups.push_back(trial.group);
  std::ranges::sort(groups);
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  for (Trial& trial : trials) {
    const auto at = std::ranges::lower_bound(groups, trial.group);
    trial.group = static_cast<std::size_t>(at - groups.begin());
  }
  std::vector<double> weights(groups.size(), 1);
  const auto crossing = [&] {
    return std::max(isotonic_crossing(trials, weights, share, nowhere), out.reach.low);
  };
  out.value = crossing();
  out.ci95 = bootstrap_interval_of_groups(
      groups.size(),
      [&](std::span<const std::size_t> drawn) {
        std::ranges::fill(weights, 0.0);
        for (const std::size_t group : drawn) weights[group] += 1;
        return crossing();
      },
      name);
  return out;
}

int area_of(const Sheet& sheet, const Eigen::Vector2d& place_mm, int areas) {
  const Eigen::Vector2d from_corner = place_mm / sheet.unit_mm() - sheet.bounds().min();
  const Eigen::Vector2d share = from_corner.cwiseQuotient(sheet.bounds().sizes());
  return area_slot(share.x(), areas) + areas * area_slot(share.y(), areas);
}

std::vector<int> area_orbits(const Sheet& sheet, int areas) {
  const int count = areas * areas;
  // The least area that each one is taken to. A symmetry that takes an area between others, as the
  // finer rotations of a disc do, joins nothing.
  std::vector<int> least(static_cast<std::size_t>(count));
  std::iota(least.begin(), least.end(), 0);
  for (const Eigen::Matrix2d& symmetry : sheet.symmetries()) {
    for (int area = 0; area < count; ++area) {
      const Eigen::Vector2d moved = symmetry * middle_of_area(sheet, area, areas);
      const Eigen::Vector2d place_mm = sheet.unit_mm() * (sheet.bounds().center() + moved);
      const int other = area_of(sheet, place_mm, areas);
      if ((middle_of_area(sheet, other, areas) - moved).norm() > 1e-9) continue;
      int& kept = least[static_cast<std::size_t>(area)];
      kept = std::min(kept, other);
    }
  }
  // An area's ring, then its distance from the middle, both in steps of areas.
  const auto outward = [areas](int area) {
    const double x = std::abs(area % areas - (areas - 1) / 2.0);
    const double y = std::abs(area / areas - (areas - 1) / 2.0);
    return std::pair(std::max(x, y), std::hypot(x, y));
  };
  std::vector<int> firsts = distinct(least);
  std::ranges::sort(firsts);
  std::ranges::stable_sort(firsts, std::greater<>(), outward);
  std::vector<int> orbits;
  for (const int area : least) {
    orbits.push_back(static_cast<int>(std::ranges::find(firsts, area) - firsts.begin()));
  }
  return orbits;
}

std::string roman(int orbit) {
  if (orbit < 0) throw std::invalid_argument("orbits are counted from 0");
  static const std::vector<std::pair<int, const char*>> digits = {
      {1000, "M"}, {900, "CM"}, {500, "D"}, {400, "CD"}, {100, "C"}, {90, "XC"}, {50, "L"},
      {40, "XL"},  {10, "X"},   {9, "IX"},  {5, "V"},    {4, "IV"},  {1, "I"}};
  std::string out;
  int rest = orbit + 1;
  for (const auto& [value, digit] : digits) {
    for (; rest >= value; rest -= value) out += digit;
  }
  return out;
}

}  // namespace ertbench
