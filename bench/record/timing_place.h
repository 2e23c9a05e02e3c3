#pragma once

#include <string>

namespace ertbench {

/// Where and beside what a row's times were measured.
struct TimingPlace {
  std::string cpu;   ///< the processor's name; empty where an earlier version did not say
  std::string node;  ///< the machine's
  /// Cores that other processes kept busy meanwhile, the most of the rounds.
  double busy_cores = 0;

  bool operator==(const TimingPlace&) const = default;
};

/// From how many cores on others are said to have disturbed the clock.
inline constexpr double least_disturbing_cores = 0.25;

}  // namespace ertbench
