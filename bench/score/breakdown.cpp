#include "bench/score/breakdown.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/random.h"

namespace ertbench {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The share of failing frames at each level, a frame counting `weights` times.
std::vector<double> shares(std::span<const LadderStep> ladder, const std::vector<int>& weights) {
  std::vector<double> out;
  for (const LadderStep& step : ladder) {
    int failed = 0;
    for (std::size_t f = 0; f < weights.size(); ++f) failed += weights[f] * step.failed[f];
    out.push_back(failed / static_cast<double>(weights.size()));
  }
  return out;
}

/// Where the share first exceeds the limit, in levels from the first: -infinity where it does
/// there, infinity where it does nowhere.
double crossing(const std::vector<double>& shares, double limit, Between between) {
  if (shares.front() > limit) return -infinity;
  for (std::size_t i = 1; i < shares.size(); ++i) {
    if (shares[i] <= limit) continue;
    if (between == Between::nothing) return static_cast<double>(i);
    return static_cast<double>(i - 1) + (limit - shares[i - 1]) / (shares[i] - shares[i - 1]);
  }
  return infinity;
}

/// The level there.
double level_at(std::span<const LadderStep> ladder, double place, Between between) {
  const auto last = static_cast<double>(ladder.size() - 1);
  const auto below =
      std::min(static_cast<std::size_t>(std::clamp(place, 0.0, last)), ladder.size() - 2);
  const double weight = std::clamp(place, 0.0, last) - static_cast<double>(below);
  const double a = ladder[below].level;
  const double b = ladder[below + 1].level;
  if (between == Between::logarithmic) return a * std::pow(b / a, weight);
  return a + weight * (b - a);
}

std::optional<double> if_within(std::span<const LadderStep> ladder, double place, Between between) {
  if (std::isinf(place)) return std::nullopt;
  return level_at(ladder, place, between);
}

void check(std::span<const LadderStep> ladder, Between between) {
  const auto refuse = [](const char* what) {
    throw std::invalid_argument(std::string("ladder: ") + what);
  };
  if (ladder.size() < 2) refuse("needs two levels at least");
  const bool rises = ladder[1].level > ladder[0].level;
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    if (ladder[i].failed.empty() || ladder[i].failed.size() != ladder[0].failed.size()) {
      refuse("needs the same frames at every level, one at least");
    }
    if (between == Between::logarithmic && !(ladder[i].level > 0))
      refuse("a logarithmic one needs levels > 0");
    if (i == 0) continue;
    const double step = ladder[i].level - ladder[i - 1].level;
    if (!(rises ? step > 0 : step < 0)) refuse("levels must rise, or fall, throughout");
  }
}

}  // namespace

double LadderStep::share() const {
  return std::accumulate(failed.begin(), failed.end(), 0.0) / static_cast<double>(failed.size());
}

Breakdown break_down(std::span<const LadderStep> ladder, double share, Between between,
                     std::string_view name) {
  check(ladder, between);
  const std::size_t frames = ladder.front().failed.size();
  std::vector<int> weights(frames, 1);
  const double place = crossing(shares(ladder, weights), share, between);
  Breakdown out;
  out.state = std::isinf(place) ? (place < 0 ? BreakState::at_mildest : BreakState::never)
                                : BreakState::breaks;
  out.level = level_at(ladder, place, between);
  const auto scaled = [&](double level) {
    return between == Between::logarithmic ? std::log(level) : level;
  };
  const double first = scaled(ladder.front().level);
  out.place = (scaled(out.level) - first) / (scaled(ladder.back().level) - first);

  std::vector<double> places;
  for (std::uint64_t resample = 0; resample < kBreakdownResamples; ++resample) {
    RandomStream random(0, key_of(name), resample, Purpose::scene);
    std::fill(weights.begin(), weights.end(), 0);
    for (std::size_t f = 0; f < frames; ++f) {
      ++weights[static_cast<std::size_t>(random.uniform() * static_cast<double>(frames))];
    }
    places.push_back(crossing(shares(ladder, weights), share, between));
  }
  std::sort(places.begin(), places.end());
  constexpr std::size_t tail = kBreakdownResamples / 40;  // 2.5 %
  out.mild = if_within(ladder, places[tail], between);
  out.severe = if_within(ladder, places[places.size() - 1 - tail], between);
  return out;
}

WorkingRange working_range(std::span<const LadderStep> ladder, double share, Between between,
                           std::string_view name) {
  check(ladder, between);
  double least = infinity;
  for (const LadderStep& step : ladder) least = std::min(least, step.share());
  std::vector<std::size_t> best;
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    if (ladder[i].share() == least) best.push_back(i);
  }
  WorkingRange out;
  out.best = best[best.size() / 2];
  if (out.best > 0) {
    std::vector<LadderStep> down(ladder.begin(),
                                 ladder.begin() + static_cast<std::ptrdiff_t>(out.best) + 1);
    std::reverse(down.begin(), down.end());
    out.to_first = break_down(down, share, between, name);
  }
  if (out.best + 1 < ladder.size()) {
    out.to_last = break_down(ladder.subspan(out.best), share, between, name);
  }
  return out;
}

}  // namespace ertbench
