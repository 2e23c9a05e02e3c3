#pragma once

#include <array>
#include <complex>
#include <cstddef>

namespace ertbench {

/// Points at which a border is looked at before its points are chosen, at equal parameters.
inline constexpr std::size_t gathering_probes = 16;

/// How the points of a closed border are drawn together by the map exp(is) -> exp(it) of the unit
/// circle onto itself, a Moebius map: they are 1 / strength times as dense at the parameter
/// `towards` as equal ones, and as much thinner on the far side. What is smooth in t is so in s.
struct Gathering {
  double strength = 1;
  double towards = 0;
  double count = 0;  ///< points that it takes
};

/// Where the point stands that belongs to an equal parameter s, and dt/ds. All without an angle:
/// points are taken by the hundred thousand.
struct Gathered {
  std::complex<double> turn;  ///< exp(i (t - towards))
  double slope;
};
/// `half` is exp(i (s - towards) / 2).
Gathered gathered(std::complex<double> half, const Gathering& gathering);

/// What takes the fewest points, `demand` being how many equal ones would do if all the border were
/// as at each probe, and `least` how many it takes anyway.
Gathering gathering_for(const std::array<double, gathering_probes>& demand, double least);

}  // namespace ertbench
