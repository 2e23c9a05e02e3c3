#include "bench/studies/tracking_scores.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "core/bootstrap.h"
#include "core/wilson_interval.h"

namespace ertbench {
namespace {

/// What one character adds to the two sums of a ratio.
struct RatioPart {
  double of = 0;
  double in = 0;
};

/// The sum of all `of` over the sum of all `in`.
std::optional<Estimate> ratio_over_characters(
    std::span<const TrackedCharacter> characters,
    const std::function<RatioPart(const TrackedCharacter&)>& part_of, const std::string& key) {
  std::map<std::string, RatioPart> by_name;
  for (const TrackedCharacter& character : characters) {
    const RatioPart part = part_of(character);
    if (part.in <= 0) continue;
    by_name[character.name].of += part.of;
    by_name[character.name].in += part.in;
  }
  if (by_name.empty()) return std::nullopt;
  std::vector<RatioPart> groups;
  std::vector<std::size_t> all;
  for (const auto& [name, part] : by_name) {
    all.push_back(groups.size());
    groups.push_back(part);
  }
  const auto ratio = [&](std::span<const std::size_t> drawn) {
    RatioPart sum;
    for (const std::size_t group : drawn) {
      sum.of += groups[group].of;
      sum.in += groups[group].in;
    }
    return sum.of / sum.in;
  };
  return Estimate{ratio(all), bootstrap_interval_of_groups(groups.size(), ratio, key)};
}

/// Mean over the characters that have the value, times `factor`; counts them in `count`.
std::optional<Estimate> mean_over_characters(std::span<const TrackedCharacter> characters,
                                             std::optional<double> TrackedCharacter::*value,
                                             double factor, int& count, const std::string& key) {
  count = static_cast<int>(
      std::count_if(characters.begin(), characters.end(),
                    [&](const TrackedCharacter& one) { return (one.*value).has_value(); }));
  return ratio_over_characters(
      characters,
      [&](const TrackedCharacter& one) {
        return one.*value ? RatioPart{factor * *(one.*value), 1} : RatioPart{};
      },
      key);
}

}  // namespace

TrackingScores tracking_scores(std::span<const TrackedCharacter> characters,
                               const std::string& key) {
  TrackingScores out;
  if (characters.empty()) return out;
  const auto mean_of = [&](std::optional<double> TrackedCharacter::*value, double factor,
                           int& count, const char* name) {
    return mean_over_characters(characters, value, factor, count, key + " " + name);
  };
  out.rms_mm = mean_of(&TrackedCharacter::rms_mm, 1, out.with_rms, "rms");
  out.rms_without_lag_mm =
      mean_of(&TrackedCharacter::rms_without_lag_mm, 1, out.with_lag, "rms without lag");
  out.lag_ms = mean_of(&TrackedCharacter::lag_s, 1000, out.with_lag, "lag");
  out.frechet_mm = mean_of(&TrackedCharacter::frechet_mm, 1, out.with_frechet, "Fréchet");
  const auto ratio_of = [&](auto of, auto in, const char* name) {
    return ratio_over_characters(
        characters,
        [&](const TrackedCharacter& one) {
          return RatioPart{static_cast<double>(of(one)), static_cast<double>(in(one))};
        },
        key + " " + name);
  };
  using One = TrackedCharacter;
  out.drop_outs = ratio_of([](const One& one) { return one.lost; },
                           [](const One& one) { return one.touched; }, "drop-outs");
  out.dropped_frames = ratio_of([](const One& one) { return one.frames - one.worked_on; },
                                [](const One& one) { return one.frames; }, "dropped");
  out.ghosts = ratio_of([](const One& one) { return one.ghosts; },
                        [](const One& one) { return one.worked_on; }, "ghosts");
  const auto read = static_cast<int>(
      std::count_if(characters.begin(), characters.end(), std::mem_fn(&One::read_back)));
  const auto all = static_cast<int>(characters.size());
  out.read_back = Estimate{static_cast<double>(read) / all, wilson_interval(read, all)};
  return out;
}

std::optional<double> enough_frame_rate(std::span<const RateValue> rates, bool most_is_best) {
  constexpr double within = 0.05;
  std::optional<double> best;
  for (const RateValue& one : rates) {
    if (!one.value) continue;
    if (!best || (most_is_best ? *one.value > *best : *one.value < *best)) best = one.value;
  }
  if (!best || (most_is_best && *best <= 0)) return std::nullopt;
  const double limit = *best * (most_is_best ? 1 - within : 1 + within);
  std::optional<double> least;
  for (const RateValue& one : rates) {
    if (!one.value || (most_is_best ? *one.value < limit : *one.value > limit)) continue;
    least = std::min(least.value_or(one.frame_rate), one.frame_rate);
  }
  return least;
}

std::vector<EnoughFrameRate> enough_frame_rates(std::span<const TrackingCondition> conditions) {
  std::vector<EnoughFrameRate> out;
  if (conditions.empty()) return out;
  std::map<std::pair<std::string, double>, std::vector<const TrackingCondition*>> alike;
  for (const TrackingCondition& one : conditions) {
    alike[{one.noise, one.speed_mm_s}].push_back(&one);
  }
  for (std::size_t s = 0; s < conditions.front().solvers.size(); ++s) {
    for (const auto& [which, group] : alike) {
      std::set<double> tried;
      std::vector<RateValue> shares;
      std::vector<RateValue> distances;
      for (const TrackingCondition* one : group) {
        const TrackingScores& scores = one->solvers[s].scores;
        const auto value = [](const std::optional<Estimate>& score) {
          return score ? std::optional(score->value) : std::nullopt;
        };
        tried.insert(one->frame_rate);
        shares.push_back({one->frame_rate, value(scores.read_back)});
        distances.push_back({one->frame_rate, value(scores.rms_mm)});
      }
      if (tried.size() < 2) continue;
      out.push_back({conditions.front().solvers[s].label,
                     which.second,
                     which.first,
                     {tried.begin(), tried.end()},
                     enough_frame_rate(shares, true),
                     enough_frame_rate(distances, false)});
    }
  }
  return out;
}

}  // namespace ertbench
