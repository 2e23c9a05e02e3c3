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

Gathered gathered(std::complex<double> half, const Gathering& gathering) {
  // tan((t - towards) / 2) = strength tan((s - towards) / 2).
  const double c = half.real();
  const double d = gathering.strength * half.imag();
  const double square = c * c + d * d;
  return {{(c * c - d * d) / square, 2 * c * d / square}, gathering.strength / square};
}

Gathering gathering_for(const std::array<double, gathering_probes>& demand, double least) {
  static const std::array<std::complex<double>, gathering_probes> halves = [] {
    std::array<std::complex<double>, gathering_probes> out;
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      out[i] = std::polar(1.0, std::numbers::pi * static_cast<double>(i) / gathering_probes);
    }
    return out;
  }();
  const auto worst = std::max_element(demand.begin(), demand.end());
  const auto from_probe = static_cast<std::size_t>(worst - demand.begin());
  Gathering best{1, 2 * std::numbers::pi * static_cast<double>(from_probe) / gathering_probes,
                 std::max(*worst, least)};
  for (const double strength : gathering_strengths) {
    if (best.count <= least) break;
    double count = least;
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      const std::size_t from = (i + gathering_probes - from_probe) % gathering_probes;
      const double c = strength * halves[from].real();
      const double d = halves[from].imag();
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
