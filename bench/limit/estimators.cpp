#include "bench/limit/estimators.h"

#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

constexpr int most_weiszfeld_steps = 100;

Eigen::VectorXd distances(const WeightedSamples& samples, const Eigen::RowVectorXd& from) {
  return (samples.values.rowwise() - from).rowwise().norm();
}

}  // namespace

Eigen::RowVectorXd posterior_mean(const WeightedSamples& samples) {
  return samples.weights.transpose() * samples.values / samples.weights.sum();
}

double expected_distance(const WeightedSamples& samples, const Eigen::VectorXd& scales,
                         const Eigen::RowVectorXd& estimate) {
  const Eigen::VectorXd apart = distances(samples, estimate);
  return (samples.weights.array() * scales.array() * apart.array()).sum() / samples.weights.sum();
}

Eigen::RowVectorXd weighted_median_point(const WeightedSamples& samples,
                                         const Eigen::VectorXd& scales) {
  Eigen::RowVectorXd estimate = posterior_mean(samples);
  double before = expected_distance(samples, scales, estimate);
  for (int step = 0; step < most_weiszfeld_steps; ++step) {
    const Eigen::VectorXd apart = distances(samples, estimate);
    // A sample that the estimate meets would take all the weight.
    const double least = 1e-6 * apart.maxCoeff() + 1e-300;
    const Eigen::VectorXd pull =
        samples.weights.array() * scales.array() / apart.array().max(least);
    const double sum = pull.sum();
    if (!(sum > 0) || !std::isfinite(sum)) return estimate;
    const Eigen::RowVectorXd next = pull.transpose() * samples.values / sum;
    const double after = expected_distance(samples, scales, next);
    if (!(after < before)) return estimate;
    estimate = next;
    if (before - after < 1e-7 * before) return estimate;
    before = after;
  }
  return estimate;
}

double total_variance(const WeightedSamples& samples) {
  const Eigen::VectorXd apart = distances(samples, posterior_mean(samples));
  return samples.weights.dot(apart.cwiseAbs2()) / samples.weights.sum();
}

double effective_samples(const WeightedSamples& samples) {
  const auto& weights = samples.weights;
  const double kish = weights.sum() * weights.sum() / weights.squaredNorm();
  const int islands = samples.islands.empty()
                          ? 1
                          : *std::max_element(samples.islands.begin(), samples.islands.end()) + 1;
  if (islands < 2) return kish;
  RowMajorMatrix means = RowMajorMatrix::Zero(islands, samples.values.cols());
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(islands);
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const int island = samples.islands[static_cast<std::size_t>(i)];
    means.row(island) += weights[i] * samples.values.row(i);
    sums[island] += weights[i];
  }
  if (sums.minCoeff() <= 0) return 1;
  means.array().colwise() /= sums.array();
  const Eigen::VectorXd shares = sums / sums.sum();
  const Eigen::RowVectorXd middle = shares.transpose() * means;
  const double of_mean =
      shares.cwiseAbs2().dot((means.rowwise() - middle).rowwise().squaredNorm()) * islands /
      (islands - 1.0);
  const double variance = total_variance(samples);
  return of_mean * kish > variance ? variance / of_mean : kish;
}

double weighted_rank(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::VectorXd& weights, double truth, double uniform) {
  const double tie = 1e-9 * (1 + std::abs(truth));
  double below = 0;
  double equal = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::abs(values[i] - truth) <= tie) {
      equal += weights[i];
    } else if (values[i] < truth) {
      below += weights[i];
    }
  }
  return (below + uniform * equal) / weights.sum();
}

}  // namespace ertbench
