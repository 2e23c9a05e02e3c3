#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace ertbench {

/// Latencies of any number of frames in a fixed memory: counts in classes that are equally wide on
/// a logarithmic scale, from 1 µs to 100 s, each 2.3 % wider than the one before. What is outside
/// counts in the first or the last class; the largest is kept as it is.
class LatencyHistogram {
 public:
  static constexpr int classes_per_decade = 100;
  static constexpr int decades = 8;

  void add(double seconds);
  std::uint64_t count() const { return count_; }
  double largest_s() const { return largest_s_; }

  /// The upper end of the class in which the nearest rank lies, the largest where that is less:
  /// at most 2.3 % too much. Nothing where there is no latency. `share` 0 ... 1.
  std::optional<double> quantile_s(double share) const;

  /// Counts by coarser classes, `per_decade` of them, which must divide classes_per_decade.
  std::vector<std::uint64_t> coarse(int per_decade) const;

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(classes_per_decade* decades)> counts_{};
  std::uint64_t count_ = 0;
  double largest_s_ = 0;
};

}  // namespace ertbench
