#include "bench/studies/targets_gaps.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/plot/axis.h"
#include "core/bootstrap.h"
#include "core/quantile.h"
#include "core/text.h"
#include "core/wilson_interval.h"

namespace ertbench {
namespace {

/// Where a fit reaches kResolvedShare; nothing where it does not.
std::optional<double> gap_reached(const std::vector<IsotonicBlock>& fit) {
  // The slack lets a share of 4 in 5 count, whatever the rounding of its mean.
  const auto resolves = [](const IsotonicBlock& b) { return b.value >= kResolvedShare - 1e-9; };
  const auto reached = std::find_if(fit.begin(), fit.end(), resolves);
  double scenes = 0;
  for (auto block = reached; block != fit.end(); ++block) scenes += block->weight;
  if (scenes < kLeastResolvedScenes) return std::nullopt;
  if (reached == fit.begin()) return reached->first;
  const IsotonicBlock& before = *std::prev(reached);
  const double share = (kResolvedShare - before.value) / (reached->value - before.value);
  return before.last + share * (reached->first - before.last);
}

std::vector<WeightedPoint> gap_points(std::span<const GapTrial> trials) {
  std::vector<WeightedPoint> points;
  for (const GapTrial& trial : trials) points.push_back({trial.gap_mm, trial.share(), 1});
  return points;
}

ResolvableGap resolvable_gap(std::span<const GapTrial> trials,
                             const std::vector<IsotonicBlock>& fit) {
  using State = ResolvableGap::State;
  ResolvableGap out;
  if (trials.size() < kLeastResolvedScenes) return out;
  const double least = trials.front().gap_mm;
  const double largest = trials.back().gap_mm;
  out.gap_mm = gap_reached(fit);
  out.state = !out.gap_mm ? State::never : *out.gap_mm <= least ? State::always : State::resolved;

  // A resample that resolves nothing stands beyond the set, at its largest gap.
  std::vector<WeightedPoint> points = gap_points(trials);
  const Interval interval = bootstrap_interval_of_groups(
      trials.size(),
      [&](std::span<const std::size_t> drawn) {
        for (WeightedPoint& point : points) point.weight = 0;
        for (const std::size_t trial : drawn) points[trial].weight += 1;
        return gap_reached(isotonic_fit(points)).value_or(largest);
      },
      "resolvable gap");
  if (interval.low > least) out.low_mm = interval.low;
  if (interval.high < largest) out.high_mm = interval.high;
  return out;
}

Estimate told_apart_in(const std::vector<GapTrial>& trials) {
  double sum = 0;
  bool single = true;
  int told_apart = 0;
  std::vector<double> shares;
  for (const GapTrial& trial : trials) {
    sum += trial.share();
    single = single && trial.frames == 1;
    told_apart += trial.told_apart;
    shares.push_back(trial.share());
  }
  const auto count = static_cast<int>(trials.size());
  return {sum / count, single ? wilson_interval(told_apart, count)
                              : bootstrap_interval_of_mean(shares, "told apart")};
}

/// About ten bins of round width for nine tenths of the scenes; if the few widest gaps reach far
/// beyond those, they share the last.
std::vector<GapBin> gap_bins(std::span<const GapTrial> trials) {
  std::vector<double> gaps;
  for (const GapTrial& trial : trials) gaps.push_back(trial.gap_mm);
  const double usual = interpolated_quantile(gaps, 0.9);
  const double span = usual - gaps.front();
  const double step = span > 0 ? round_step(span, 10) : 1;
  // The slack keeps a gap of 0.3 out of the bin that ends there.
  const auto number_of = [&](double gap) { return std::lround(std::floor(gap / step + 1e-9)); };
  const long last = number_of(usual) + 1;
  const long end = number_of(gaps.back()) + 1;

  std::map<long, std::vector<GapTrial>> filled;
  for (const GapTrial& trial : trials) {
    filled[std::min(number_of(trial.gap_mm), last)].push_back(trial);
  }
  std::vector<GapBin> bins;
  for (const auto& [number, members] : filled) {
    GapBin bin;
    bin.low_mm = step * static_cast<double>(number);
    bin.high_mm = step * static_cast<double>(number == last ? end : number + 1);
    bin.scenes = static_cast<int>(members.size());
    for (const GapTrial& trial : members) bin.mean_gap_mm += trial.gap_mm / bin.scenes;
    bin.told_apart = told_apart_in(members);
    bins.push_back(bin);
  }
  return bins;
}

}  // namespace

std::vector<GapTrial> gap_trials(std::span<const TargetFrame> frames,
                                 std::span<const std::optional<ContactScore>> scores) {
  std::map<std::size_t, GapTrial> by_scene;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::optional<double> gap = frames[f].gap_mm();
    if (!gap || !scores[f]) continue;
    GapTrial& trial = by_scene[frames[f].scene];
    trial.gap_mm = *gap;
    ++trial.frames;
    trial.told_apart += scores[f]->matched == 2 ? 1 : 0;
  }
  std::vector<GapTrial> trials;
  for (const auto& [scene, trial] : by_scene) trials.push_back(trial);
  std::stable_sort(trials.begin(), trials.end(),
                   [](const GapTrial& a, const GapTrial& b) { return a.gap_mm < b.gap_mm; });
  return trials;
}

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

TargetGaps measure_gaps(std::span<const GapTrial> trials) {
  TargetGaps out;
  if (trials.empty()) return out;
  out.scenes = static_cast<int>(trials.size());
  out.least_mm = trials.front().gap_mm;
  out.largest_mm = trials.back().gap_mm;
  out.bins = gap_bins(trials);
  out.fit = isotonic_fit(gap_points(trials));
  out.resolvable = resolvable_gap(trials, out.fit);
  return out;
}

std::string ResolvableGap::text() const {
  switch (state) {
    case State::resolved:
      return fixed(*gap_mm, 1);
    case State::always:
      return "≤ " + fixed(*gap_mm, 1);
    case State::never:
    case State::too_few_pairs:
      break;
  }
  return name_of(state);
}

std::string ResolvableGap::interval() const {
  if (state == State::too_few_pairs) return "";
  return interval_text(low_mm ? fixed(*low_mm, 1) : "< set",
                       high_mm ? fixed(*high_mm, 1) : "> set");
}

const char* name_of(ResolvableGap::State state) {
  switch (state) {
    case ResolvableGap::State::resolved:
      return "resolved";
    case ResolvableGap::State::always:
      return "at the least gap already";
    case ResolvableGap::State::never:
      return "not within the set";
    case ResolvableGap::State::too_few_pairs:
      break;
  }
  return "too few pairs";
}

}  // namespace ertbench
