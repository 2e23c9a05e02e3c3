#include "core/paired_bootstrap.h"

#include <Random123/philox.h>
#include <xxhash.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "core/bootstrap.h"
#include "core/quantile.h"

namespace ertbench {
namespace {

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

/// The mean over seeds in resample `r`, of the seeds' means there.
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
  const SortedValues sorted =
      std::vector<double>(differences.data(), differences.data() + differences.size());
  return {interpolated_quantile(sorted, 0.025), interpolated_quantile(sorted, 0.975)};
}

}  // namespace ertbench
