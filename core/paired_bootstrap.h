#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "core/interval.h"

namespace ertbench {

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
