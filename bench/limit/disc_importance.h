#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "bench/limit/annealed_sampler.h"
#include "core/random.h"

namespace ertbench {

/// A posterior over a few numbers that has one mode or some, each about Gaussian.
struct LaplaceProblem {
  Eigen::VectorXd low, high;  ///< [dimension] the box outside of which there is nothing
  /// Residuals whose squares' sum is -2 log of the likelihood, about; [any]
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  /// Logarithm of the target, exactly, up to a constant; -infinity where there is nothing.
  std::function<std::vector<double>(std::span<const Eigen::VectorXd>)> log_target;
};

struct WeightedPoints {
  std::vector<Eigen::VectorXd> points;
  Eigen::VectorXd weights;  ///< [points], adding up to 1
  double pareto_k = 0;      ///< of the largest weights; above .7 nothing holds
  double effective = 0;     ///< Kish's number of points in force
  std::size_t modes = 0;
};

/// Importance sampling from the Laplace approximation: Levenberg-Marquardt from every start, a
/// mixture of Student distributions around what it finds and, as a defence, a tenth of uniform
/// points, refitted a few times to the moments of the points that it gives, and the smoothed
/// weights (pareto_smoothed).
WeightedPoints sample_by_importance(const LaplaceProblem& problem,
                                    std::span<const Eigen::VectorXd> starts, int points,
                                    RandomStream& random);

/// Puts the expected order statistics of a generalised Pareto distribution, fitted to them, in the
/// place of the largest weights (PSIS: Vehtari et al. 2024; fit by Zhang and Stephens 2009), and
/// returns its shape k. Of fewer than 25 weights nothing is changed.
double pareto_smoothed(Eigen::VectorXd& weights);

/// The posterior of the one disc of a prior that knows no other scenes. `likelihood` is of smooth
/// voltages. `bank` and `bank_fits` are the starts.
PosteriorSamples sample_disc_by_importance(const ScenePrior& prior,
                                           const FrameLikelihood& likelihood,
                                           std::span<const SceneDraw> bank,
                                           std::span<const SceneFit> bank_fits, int points,
                                           RandomStream& random, WeightedPoints* quality);

/// Whether the prior's scenes are one disc each, at least one quantity of which is free.
bool is_one_disc(const ScenePrior& prior);

}  // namespace ertbench
