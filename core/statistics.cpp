#include "core/statistics.h"

#include <Random123/philox.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <unsupported/Eigen/SpecialFunctions>

namespace ertbench {

double mean(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("a mean of no values was asked for");
  const auto count = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += value / count;
  return sum;
}

double sample_deviation(std::span<const double> values) {
  if (values.size() < 2) {
    throw std::invalid_argument("a standard deviation of fewer than two values was asked for");
  }
  const double middle = mean(values);
  double squares = 0;
  for (const double value : values) squares += (value - middle) * (value - middle);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

namespace {

void check(std::size_t count, double share) {
  if (count == 0) throw std::invalid_argument("a quantile of no values was asked for");
  if (!(share >= 0 && share <= 1)) {
    throw std::invalid_argument("the share of a quantile must be within 0 ... 1");
  }
}

/// P(T > t) for t >= 0 (Abramowitz and Stegun 26.7.1, as an incomplete beta function).
double upper_tail(double t, int degrees_of_freedom) {
  const double n = degrees_of_freedom;
  return 0.5 * Eigen::numext::betainc(n / 2, 0.5, n / (n + t * t));
}

constexpr std::uint32_t kSeed = 0x0e27'b007;

/// Calls `use(resample, index)` for the drawn indices below `count`, `count` of them for each
/// resample. Resample r takes its indices from the counters (0, r), (1, r), ...
template <typename Use>
void resample(std::uint64_t count, std::string_view name, const Use& use) {
  const auto hash = static_cast<std::uint32_t>(XXH64(name.data(), name.size(), 0));
  const r123::Philox4x32::key_type key = {{kSeed, hash}};
  r123::Philox4x32 philox;
  for (std::uint32_t r = 0; r < kBootstrapResamples; ++r) {
    std::uint64_t drawn = 0;
    for (std::uint32_t block = 0; drawn < count; ++block) {
      const auto words = philox({{block, r, 0, 0}}, key);
      for (std::size_t w = 0; w < words.size() && drawn < count; ++w, ++drawn) {
        // A 32-bit fraction of the count; off from uniform by count / 2^32 at most.
        use(r, (words[w] * count) >> 32U);
      }
    }
  }
}

std::vector<double> resampled_means(std::span<const double> values, std::string_view name) {
  const double scale = 1 / static_cast<double>(values.size());
  std::vector<double> means(kBootstrapResamples, 0);
  resample(values.size(), name,
           [&](std::uint32_t r, std::uint64_t index) { means[r] += values[index] * scale; });
  return means;
}

Interval interval_of(const SortedValues& values) {
  return {interpolated_quantile(values, 0.025), interpolated_quantile(values, 0.975)};
}

constexpr std::uint32_t key_of_pairs = 0x0e27'b008;

/// Draws whole numbers below `count`; the stream's counters are (0, r, s, 0), (1, r, s, 0), ...
class Draw {
 public:
  Draw(std::string_view name, std::uint32_t resample, std::uint32_t stream)
      : key_{{key_of_pairs, static_cast<std::uint32_t>(XXH64(name.data(), name.size(), 0))}},
        counter_{{0, resample, stream, 0}} {}

  Eigen::Index below(Eigen::Index count) {
    if (next_ == words_.size()) {
      words_ = philox_(counter_, key_);
      ++counter_[0];
      next_ = 0;
    }
    const std::uint64_t word = words_[next_++];
    return static_cast<Eigen::Index>((word * static_cast<std::uint64_t>(count)) >> 32U);
  }

 private:
  r123::Philox4x32 philox_;
  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
  r123::Philox4x32::ctr_type words_{};
  std::size_t next_ = r123::Philox4x32::ctr_type::static_size;
};

/// Shares of the frames in each resample [resamples, frames].
Eigen::MatrixXd frame_weights(Eigen::Index frames, std::string_view name) {
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(kBootstrapResamples, frames);
  for (Eigen::Index r = 0; r < weights.rows(); ++r) {
    Draw draw(name, static_cast<std::uint32_t>(r), 0);
    for (Eigen::Index i = 0; i < frames; ++i) weights(r, draw.below(frames)) += 1;
  }
  return weights / static_cast<double>(frames);
}

/// Mean over the resampled seeds in resample `r`; `of_seeds` holds each seed's mean there.
double resampled_mean(const Eigen::RowVectorXd& of_seeds, std::string_view name, Eigen::Index r,
                      std::size_t sample) {
  const double centre = of_seeds.mean();
  const Eigen::Index seeds = of_seeds.size();
  if (seeds == 1) return centre;
  Draw draw(name, static_cast<std::uint32_t>(r), static_cast<std::uint32_t>(sample + 1));
  double sum = 0;
  for (Eigen::Index i = 0; i < seeds; ++i) sum += of_seeds[draw.below(seeds)];
  const double n = static_cast<double>(seeds);
  return centre + std::sqrt(n / (n - 1)) * (sum / n - centre);
}

}  // namespace

SortedValues::SortedValues(std::vector<double> values) : values_(std::move(values)) {
  std::sort(values_.begin(), values_.end());
}

double interpolated_quantile(const SortedValues& values, double share) {
  check(values.size(), share);
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, values.size() - 1);
  const double weight = place - static_cast<double>(below);
  return (1 - weight) * values[below] + weight * values[above];
}

std::size_t nearest_rank(std::size_t count, double share) {
  check(count, share);
  const double rank = std::ceil(share * static_cast<double>(count));  // from 1
  return static_cast<std::size_t>(std::max(1.0, rank)) - 1;
}

double nearest_rank_quantile(const SortedValues& values, double share) {
  return values[nearest_rank(values.size(), share)];
}

double median(const SortedValues& values) { return interpolated_quantile(values, 0.5); }

double upper_median(const SortedValues& values) {
  return values[values.size() - 1 - nearest_rank(values.size(), 0.5)];
}

std::optional<Interval> binomial_median_interval(const SortedValues& values) {
  // The largest k with 1 - 2 P(Binomial(count, 1/2) < k) >= .95.
  const auto count = static_cast<double>(values.size());
  std::size_t k = 0;
  double below = 0;  // P(Binomial < k + 1), once the next term is added
  while (2 * k < values.size()) {
    const auto i = static_cast<double>(k);
    below += std::exp(std::lgamma(count + 1) - std::lgamma(i + 1) - std::lgamma(count - i + 1) -
                      count * std::numbers::ln2);
    if (1 - 2 * below < 0.95) break;
    ++k;
  }
  if (k == 0) return std::nullopt;
  return Interval{values[k - 1], values[values.size() - k]};
}

double student_t_quantile(double probability, int degrees_of_freedom) {
  if (!(probability > 0 && probability < 1) || degrees_of_freedom < 1) {
    throw std::invalid_argument("student_t_quantile: needs 0 < probability < 1, degrees >= 1");
  }
  if (probability < 0.5) return -student_t_quantile(1 - probability, degrees_of_freedom);
  double low = 0;
  double high = 1;
  while (upper_tail(high, degrees_of_freedom) > 1 - probability) high *= 2;
  while (high - low > 1e-12 * high) {
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (upper_tail(middle, degrees_of_freedom) > 1 - probability ? low : high) = middle;
  }
  return high;
}

Interval wilson_interval(int count, int total) {
  if (total < 1 || count < 0 || count > total) {
    throw std::invalid_argument("wilson_interval: needs 0 <= count <= total, total >= 1");
  }
  constexpr double z = 1.959963984540054;  // normal quantile of 0.975
  const double n = total;
  const double share = count / n;
  const double middle = share + z * z / (2 * n);
  const double reach = z * std::sqrt(share * (1 - share) / n + z * z / (4 * n * n));
  const double stretch = 1 + z * z / n;
  // At a share of 0 or 1 rounding would put the end beyond it.
  return {count == 0 ? 0 : (middle - reach) / stretch,
          count == total ? 1 : (middle + reach) / stretch};
}

Interval bootstrap_interval_of_mean(std::span<const double> values, std::string_view name) {
  if (values.empty()) throw std::invalid_argument("an interval of no values was asked for");
  if (values.size() == 1) return {values[0], values[0]};
  return interval_of(resampled_means(values, name));
}

Interval bootstrap_interval_of_groups(
    std::size_t groups, const std::function<double(std::span<const std::size_t>)>& statistic,
    std::string_view name) {
  if (groups == 0) throw std::invalid_argument("an interval of no groups was asked for");
  std::vector<std::vector<std::size_t>> drawn(kBootstrapResamples);
  resample(groups, name, [&](std::uint32_t r, std::uint64_t index) { drawn[r].push_back(index); });
  std::vector<double> values;
  for (const auto& numbers : drawn) values.push_back(statistic(numbers));
  return interval_of(std::move(values));
}

std::optional<RatioOfSums> ratio_of_sums(std::span<const double> above,
                                         std::span<const double> below, std::string_view name) {
  const double all = std::accumulate(below.begin(), below.end(), 0.0);
  if (!(all > 0)) return std::nullopt;
  RatioOfSums out;
  out.ratio = std::accumulate(above.begin(), above.end(), 0.0) / all;
  const auto of_drawn = [&](std::span<const std::size_t> drawn) {
    double over = 0;
    double under = 0;
    for (const std::size_t i : drawn) {
      over += above[i];
      under += below[i];
    }
    return under > 0 ? over / under : out.ratio;
  };
  out.ci95 = bootstrap_interval_of_groups(above.size(), of_drawn, name);
  return out;
}

PairedBootstrap::PairedBootstrap(std::span<const Eigen::MatrixXd> samples, std::string_view name) {
  const Eigen::Index frames = samples.empty() ? 0 : samples.front().cols();
  const Eigen::MatrixXd weights = frame_weights(frames, name);
  resampled_.resize(weights.rows(), static_cast<Eigen::Index>(samples.size()));
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Eigen::MatrixXd& sample = samples[s];
    if (sample.cols() != frames || sample.size() == 0) {
      throw std::invalid_argument("a paired comparison needs the same frames, one at least");
    }
    means_.push_back(sample.mean());
    const Eigen::MatrixXd of_seeds = weights * sample.transpose();  // [resamples, seeds]
    for (Eigen::Index r = 0; r < weights.rows(); ++r) {
      resampled_(r, static_cast<Eigen::Index>(s)) = resampled_mean(of_seeds.row(r), name, r, s);
    }
  }
}

Interval PairedBootstrap::interval(std::size_t a, std::size_t b) const {
  const Eigen::VectorXd differences =
      resampled_.col(static_cast<Eigen::Index>(a)) - resampled_.col(static_cast<Eigen::Index>(b));
  return interval_of(std::vector<double>(differences.begin(), differences.end()));
}

}  // namespace ertbench
