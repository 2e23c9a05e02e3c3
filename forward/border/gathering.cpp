#include "forward/border/gathering.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

/// How strongly points may be drawn together: the far side is to keep enough of them.
constexpr std::array gathering_strengths = {0.8, 0.64, 0.5, 0.4, 0.32};
/// Of the points that a border needs anyway, what will do on the far side.
constexpr double least_far_off = 0.5;

}  // namespace

Gathered gathered(double s, const Gathering& gathering) {
  if (gathering.strength >= 1) return {s, 1};
  const double half = std::remainder(s - gathering.towards, 2 * std::numbers::pi) / 2;
  const double c = std::cos(half);
  const double d = gathering.strength * std::sin(half);
  return {gathering.towards + 2 * std::atan2(d, c), gathering.strength / (c * c + d * d)};
}

Gathering gathering_for(const std::array<double, gathering_probes>& demand, double least) {
  const auto worst = std::max_element(demand.begin(), demand.end());
  Gathering best{
      1, 2 * std::numbers::pi * static_cast<double>(worst - demand.begin()) / gathering_probes,
      std::max(*worst, least)};
  for (const double strength : gathering_strengths) {
    if (best.count <= least) break;
    double count = least;
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      const double half =
          std::numbers::pi * static_cast<double>(i) / gathering_probes - best.towards / 2;
      const double c = strength * std::cos(half);
      const double d = std::sin(half);
      // dt/ds at this t.
      count =
          std::max(count, std::max(demand[i], least_far_off * least) * (c * c + d * d) / strength);
    }
    if (count < best.count) {
      best.count = count;
      best.strength = strength;
    }
  }
  return best;
}

}  // namespace ertbench
