#include "bench/studies/detection_share.h"

#include <algorithm>
#include <cmath>

#include "core/bootstrap.h"
#include "core/wilson_interval.h"

namespace ertbench {
namespace {

constexpr double isotonic_bin = 20;  ///< trials

void sort_trials(std::vector<Trial>& trials) {
  std::stable_sort(trials.begin(), trials.end(),
                   [](const Trial& a, const Trial& b) { return a.value < b.value; });
}

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
  const auto reached = std::find_if(blocks.begin(), blocks.end(),
                                    [&](const Block& block) { return block.sum.share() >= share; });
  if (reached == blocks.end()) return nowhere;
  const double right = bins[reached->first].mean();
  if (reached == blocks.begin()) return right;
  const double below = std::prev(reached)->sum.share();
  const double left = bins[reached->first - 1].mean();
  return left + (right - left) * (share - below) / (reached->sum.share() - below);
}

}  // namespace

std::optional<Estimate> CountedShare::share() const {
  if (total == 0) return std::nullopt;
  return Estimate{count / static_cast<double>(total), wilson_interval(count, total)};
}

std::vector<ShareBin> share_bins(std::vector<Trial> trials, int bins, int least_trials) {
  sort_trials(trials);
  const std::size_t most = trials.size() / static_cast<std::size_t>(least_trials);
  const std::size_t count =
      std::max<std::size_t>(std::min(static_cast<std::size_t>(bins), most), 1);
  std::vector<ShareBin> out;
  for (std::size_t b = 0; b < count && !trials.empty(); ++b) {
    const std::size_t first = b * trials.size() / count;
    const std::size_t end = (b + 1) * trials.size() / count;
    ShareBin bin{trials[first].value, trials[end - 1].value, 0, {}};
    for (std::size_t t = first; t < end; ++t) {
      bin.mean += trials[t].value / static_cast<double>(end - first);
      bin.successes.add(trials[t].success);
    }
    out.push_back(bin);
  }
  return out;
}

std::optional<LeastFound> least_found(std::vector<Trial> trials, double share,
                                      const std::string& name) {
  if (static_cast<double>(trials.size()) < 2 * isotonic_bin) return std::nullopt;
  sort_trials(trials);
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
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  for (Trial& trial : trials) {
    const auto at = std::lower_bound(groups.begin(), groups.end(), trial.group);
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
        std::fill(weights.begin(), weights.end(), 0.0);
        for (const std::size_t group : drawn) weights[group] += 1;
        return crossing();
      },
      name);
  return out;
}

}  // namespace ertbench
