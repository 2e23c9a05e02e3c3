#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// Vectors drawn from a posterior, images or places.
struct WeightedSamples {
  RowMajorMatrix values;     ///< [samples, length]
  Eigen::VectorXd weights;   ///< [samples] >= 0, with a sum above 0
  std::vector<int> islands;  ///< [samples] of the sampler that each came from, 0 ...
};

/// Least mean of the squared distance: the posterior mean, [length].
Eigen::RowVectorXd posterior_mean(const WeightedSamples& samples);

/// Least mean of scale * distance, `scales` [samples]: by Weiszfeld's iteratively reweighted means,
/// from the posterior mean on. [length]
Eigen::RowVectorXd weighted_median_point(const WeightedSamples& samples,
                                         const Eigen::VectorXd& scales);

/// The posterior's mean of scale * |value - estimate|.
double expected_distance(const WeightedSamples& samples, const Eigen::VectorXd& scales,
                         const Eigen::RowVectorXd& estimate);

/// Sum of the variances of all entries.
double total_variance(const WeightedSamples& samples);

/// How many independent samples the posterior mean is worth: the samples' variance over that of the
/// mean. With several islands, which are independent, the mean's variance is told from how far
/// theirs are apart, whatever the cause; with one the samples are independent and their weights
/// tell (Kish).
double effective_samples(const WeightedSamples& samples);

/// Where `truth` stands among the samples, 0 ... 1, ties shared out by `uniform`: uniform over
/// scenes drawn from the prior where the posterior is right (Talts et al. 2018).
double weighted_rank(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::VectorXd& weights, double truth, double uniform);

}  // namespace ertbench
