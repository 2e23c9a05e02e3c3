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

/// A number of a struct, such as the end of an interval; nothing where there is no struct.
template <class Struct, class Number>
std::optional<double> member_of(const std::optional<Struct>& whole, Number Struct::*number) {
  return whole ? std::optional<double>((*whole).*number) : std::nullopt;
}

/// Arithmetic mean. Each value is divided by the count first, so that the sum cannot overflow.
/// Throws std::invalid_argument without a value.
double mean(std::span<const double> values);

/// Sample standard deviation (n - 1 in the denominator). Throws std::invalid_argument for fewer
/// than two values.
double sample_deviation(std::span<const double> values);

/// Values in ascending order, the input of quantiles. Converts from a vector in any order; convert
/// once to compute several quantiles of the same values.
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

// Two definitions of a quantile, for two uses. The interpolated one estimates the distribution of
// the values. The nearest rank is itself one of the values, as a latency or a scale must be.
// All of them throw std::invalid_argument without a value, or if `share` is not in 0 ... 1.

/// Linear interpolation between the two ordered values next to position share (n - 1): type 7 of
/// Hyndman and Fan (1996), the default of numpy, R and Julia.
double interpolated_quantile(const SortedValues& values, double share);

/// Smallest of the values that at least `share` of them do not exceed: type 1 of Hyndman and Fan
/// (1996), usual for latencies.
double nearest_rank_quantile(const SortedValues& values, double share);
/// Index of that value among `count` ordered values, from 0.
std::size_t nearest_rank(std::size_t count, double share);

/// The middle value, or the mean of the two middle ones: interpolated_quantile at 1/2.
double median(const SortedValues& values);

/// The middle value, or the larger of the two middle ones.
double upper_median(const SortedValues& values);

/// Distribution-free 95 % interval of the median: the k-th smallest to the k-th largest value, with
/// the largest k whose coverage by the binomial distribution is at least 95 %. No value for fewer
/// than six values.
std::optional<Interval> binomial_median_interval(const SortedValues& values);

/// Quantile of Student's t distribution. Throws std::invalid_argument unless 0 < probability < 1
/// and degrees_of_freedom >= 1.
double student_t_quantile(double probability, int degrees_of_freedom);

/// Wilson's 95 % score interval of a proportion, `count` successes in `total` independent trials
/// (Wilson 1927; Newcombe 1998, method 3). Unlike the normal approximation it holds near 0 and 1.
/// Throws std::invalid_argument unless 0 <= count <= total and total >= 1.
Interval wilson_interval(int count, int total);

inline constexpr int kBootstrapResamples = 2000;

/// Percentile bootstrap 95 % interval of the mean (Efron 1979): the 2.5 and 97.5 % quantiles
/// (interpolated_quantile) of the means of `kBootstrapResamples` resamples drawn with replacement.
/// The interval of a single value is that value. Throws std::invalid_argument without a value.
///
/// Deterministic: the random numbers are Philox's, keyed by a constant and `name`, so that the same
/// values give the same interval on every machine and in any order.
Interval bootstrap_interval_of_mean(std::span<const double> values, std::string_view name);

/// Bootstrap interval of any statistic of values in groups, such as frames at the same position.
/// Whole groups are drawn, as many as there are. `statistic` gets the indices of the drawn groups,
/// 0 ... groups - 1, with repetitions. Throws std::invalid_argument without a group.
Interval bootstrap_interval_of_groups(
    std::size_t groups, const std::function<double(std::span<const std::size_t>)>& statistic,
    std::string_view name);

/// Ratio of two sums over pairs of values, such as two counts of each frame.
struct RatioOfSums {
  double ratio = 0;
  Interval ci95;  ///< by the bootstrap over the pairs
};

/// sum(above) / sum(below), with `below` >= 0 and both of one length. No value if `below` sums to
/// 0; a resample in which it does counts as the ratio itself.
std::optional<RatioOfSums> ratio_of_sums(std::span<const double> above,
                                         std::span<const double> below, std::string_view name);

/// Differences between the means of samples on the same frames, by a two-level bootstrap: each
/// resample draws frames with replacement, the same ones for every sample, and within each sample
/// seeds with replacement. The difficulty of a frame, common to all samples, cancels in their
/// differences, which are known far better than the means.
///
/// Resampling n seeds underestimates their variance by (n - 1) / n; the deviations are scaled by
/// sqrt(n / (n - 1)). A sample of one seed has no such level: its intervals hold for that training.
///
/// Deterministic, like bootstrap_interval_of_mean.
class PairedBootstrap {
 public:
  /// `samples`: each [seeds, frames], with the same number of frames. Throws std::invalid_argument
  /// without a frame or a seed, or for different numbers of frames.
  PairedBootstrap(std::span<const Eigen::MatrixXd> samples, std::string_view name);

  double mean(std::size_t sample) const { return means_[sample]; }
  double difference(std::size_t a, std::size_t b) const { return means_[a] - means_[b]; }
  /// 95 % interval of the difference: the 2.5 and 97.5 % quantiles of the resamples.
  Interval interval(std::size_t a, std::size_t b) const;

 private:
  std::vector<double> means_;
  Eigen::MatrixXd resampled_;  ///< [resamples, samples]
};

}  // namespace ertbench
