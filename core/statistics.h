#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace ertbench {

/// A 95 % interval of a statistic.
struct Interval {
  double low = 0;
  double high = 0;

  bool operator==(const Interval&) const = default;
};

/// The arithmetic mean. Each value is divided by the count first, so that the sum cannot overflow.
/// Throws std::invalid_argument where there is no value.
double mean(std::span<const double> values);

/// The sample standard deviation: of n values the squares are divided by n - 1. Throws
/// std::invalid_argument where there are fewer than two values.
double sample_deviation(std::span<const double> values);

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

/// The 95 % interval of the median, whatever the distribution: from the k-th smallest value to the
/// k-th largest, the nearest two between which the median lies with at least 95 % by the binomial
/// distribution. None for fewer than six values.
std::optional<Interval> binomial_median_interval(const SortedValues& values);

/// The value that a variable with Student's t distribution is below with `probability`, between 0
/// and 1. Throws std::invalid_argument for other values, or where there is no degree of freedom.
double student_t_quantile(double probability, int degrees_of_freedom);

/// Wilson's 95 % score interval of a share of which `count` in `total` independent trials were
/// seen (Wilson 1927; Newcombe 1998, method 3): unlike the usual one it is right for shares near 0
/// and 1 too. Throws std::invalid_argument unless 0 <= count <= total and total >= 1.
Interval wilson_interval(int count, int total);

inline constexpr int kBootstrapResamples = 2000;

/// The percentile bootstrap's 95 % interval of the mean (Efron 1979): the 2.5 and 97.5 % quantiles
/// (interpolated_quantile) of the means of `kBootstrapResamples` resamples, each drawn with
/// replacement. With one value the interval is that value. Throws std::invalid_argument for none.
///
/// Deterministic: the random numbers are Philox's, keyed by a constant and `name`, so that the same
/// values give the same interval on every machine and in whatever order statistics are made.
Interval bootstrap_interval_of_mean(std::span<const double> values, std::string_view name);

/// The same of any statistic of values that come in groups, such as frames of the same place: whole
/// groups are drawn, as many as there are. `statistic` is given the numbers of the drawn groups,
/// 0 ... groups - 1, some of them several times. Throws std::invalid_argument for no group.
Interval bootstrap_interval_of_groups(
    std::size_t groups, const std::function<double(std::span<const std::size_t>)>& statistic,
    std::string_view name);

/// The sum of some values over that of others, which come in pairs: both of the same frame, say.
struct RatioOfSums {
  double ratio = 0;
  Interval ci95;  ///< by the bootstrap over the pairs
};

/// As bootstrap_interval_of_groups. `below` >= 0, as many as `above`. Nothing where `below` sums to
/// nothing; a resample of which that is so counts as the ratio itself.
std::optional<RatioOfSums> ratio_of_sums(std::span<const double> above,
                                         std::span<const double> below, std::string_view name);

/// Differences between the means of samples that were taken on the same frames, by a bootstrap of
/// two levels: each resample draws frames with replacement, the same ones for every sample, and
/// within each sample seeds with replacement. What a difficult frame does to all samples drops out
/// of their differences, which are known far better than the means.
///
/// The seeds' means deviate in a resample by (n - 1) / n of their variance; with few seeds that is
/// made good by the factor sqrt(n / (n - 1)). One seed says nothing of that level: the intervals of
/// such a sample are those of this one training.
///
/// Deterministic, as bootstrap_interval_of_mean is.
class PairedBootstrap {
 public:
  /// `samples`: each [seeds, frames], of one number of frames. Throws std::invalid_argument where
  /// there is no frame or no seed, or the numbers of frames differ.
  PairedBootstrap(std::span<const Eigen::MatrixXd> samples, std::string_view name);

  double mean(std::size_t sample) const { return means_[sample]; }
  double difference(std::size_t a, std::size_t b) const { return means_[a] - means_[b]; }
  /// The 95 % interval of the difference, the 2.5 and 97.5 % quantiles of the resamples.
  Interval interval(std::size_t a, std::size_t b) const;

 private:
  std::vector<double> means_;
  Eigen::MatrixXd resampled_;  ///< [resamples, samples]
};

}  // namespace ertbench
