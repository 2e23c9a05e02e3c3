#pragma once

#include <cstddef>
#include <vector>

namespace ertbench {

/// Values in ascending order, which is how quantiles read them. Converts from a vector in any
/// order; sort once where several quantiles of the same values are asked for.
class SortedValues {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): median(values) is the use.
  SortedValues(std::vector<double> values);

  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  double operator[](std::size_t i) const { return values_[i]; }
  double smallest() const { return values_.front(); }
  double largest() const { return values_.back(); }

 private:
  std::vector<double> values_;
};

// Two rules, since two things are asked for. An estimate of the distribution that the values come
// from interpolates; a time that some share of the frames kept to must be one that was measured,
// and so must a frame whose size sets a scale.
// All of them throw std::invalid_argument where there is no value or `share` is not 0 ... 1.

/// Linear interpolation between the two ordered values next to the place share (n - 1): type 7 of
/// Hyndman and Fan (1996), the default of numpy, R and Julia.
double interpolated_quantile(const SortedValues& values, double share);

/// The smallest value that at least `share` of the values do not exceed, itself one of them: type 1
/// of Hyndman and Fan (1996), usual for latencies.
double nearest_rank_quantile(const SortedValues& values, double share);
/// Where it stands among `count` ordered values, from 0.
std::size_t nearest_rank(std::size_t count, double share);

/// The value in the middle, or the mean of the two in the middle: interpolated_quantile at 1/2.
double median(const SortedValues& values);

/// The largest value that at least half of the values reach, itself one of them: of two in the
/// middle the larger. It is the nearest rank counted from above.
double upper_median(const SortedValues& values);

}  // namespace ertbench
