#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/random.h"
#include "forward/data/scene_model.h"
#include "limit/annealed_sampler.h"

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

/// All images that a disc of one size and conductivity can have where pixels are filled by their
/// centres, each with its places and its voltages. The posterior over them is a sum: no sampling,
/// no derivatives, which there are none of.
class EnumeratedDiscs {
 public:
  /// `voltages` by the centres of pixels on a grid of `side`. Places stand on a lattice of
  /// `lattice` points a pixel, in x and in y.
  EnumeratedDiscs(const ScenePrior& prior, const Sensor& sensor, const SceneVoltages& voltages,
                  int side, int lattice, int threads);

  std::size_t images() const { return places_.size(); }

  /// The places of all images with a part in the posterior, with their weights. Those of one image
  /// share its weight out.
  PosteriorSamples posterior(const FrameLikelihood& likelihood) const;

 private:
  ContactDraw disc_;
  std::vector<std::vector<Eigen::Vector2d>> places_;  ///< [images]
  Frames voltages_;                                   ///< [images, channels] V
};

/// Whether such a posterior may be had: one disc, of which the place alone is free.
bool is_enumerable(const ScenePrior& prior, const SceneVoltages& voltages);

/// The ways to a posterior. `automatic` takes the exactest that the scenes allow.
enum class SamplerKind { automatic, enumeration, importance, annealing };

const std::vector<std::string>& names_of_samplers();  ///< in the order of the enumeration

/// What `automatic` stands for with these scenes; any other kind itself.
SamplerKind resolved(SamplerKind kind, const ScenePrior& prior, const SceneVoltages& voltages);

/// What is sampled for one frame, and how well.
struct SampledPosterior {
  PosteriorSamples samples;
  double pareto_k = 0;  ///< of importance sampling
};

/// Posteriors of the frames of one set under one prior. What all frames share is made once, in the
/// constructor: scenes from the prior with their voltages, or all images that there are.
///
/// const functions are thread-safe.
class PosteriorSampler {
 public:
  /// Throws InputError where the set's scenes do not allow the sampler. `voltages` must outlive
  /// this.
  PosteriorSampler(const DatasetSpec& spec, const ScenePrior& prior, const SceneVoltages& voltages,
                   SamplerKind kind, int threads);

  const ScenePrior& prior() const { return prior_; }
  std::string name() const;
  SamplerKind kind() const { return kind_; }

  /// `frame` [channels] V. `effort`: 1, or more for as many times the work. `before`: what an
  /// earlier call found for the frame, or null: where the set's own model is another than the
  /// likelihood's, their difference is taken at its scenes in place of those of a short first run.
  SampledPosterior sample(const Eigen::VectorXd& frame, int effort, const SampledPosterior* before,
                          RandomStream& random) const;

 private:
  PosteriorSamples sampled(const Eigen::VectorXd& frame, int effort, bool pilot, double* pareto_k,
                           RandomStream& random) const;
  /// The frame less what the set's own model and the likelihood's differ by, [channels] V: their
  /// mean difference over some of the scenes of `found`.
  Eigen::VectorXd corrected(const Eigen::VectorXd& frame, const PosteriorSamples& found,
                            RandomStream& random) const;

  DatasetSpec spec_;
  ScenePrior prior_;
  const SceneVoltages& voltages_;
  SamplerKind kind_;
  SceneBank bank_;
  std::unique_ptr<PlaceMetric> metric_;
  std::unique_ptr<EllipseModel> ellipses_;  ///< of joint steps, where voltages are smooth
  std::unique_ptr<EnumeratedDiscs> enumerated_;
  std::unique_ptr<SceneModel> own_;  ///< of the set, where the likelihood's model is another
};

/// Weights samples of `from` into samples of `to`: true where that is possible, every scene of `to`
/// being one of `from`, and enough of their weight is left; else they stay as they are.
bool reweight(const ScenePrior& from, const ScenePrior& to, SampledPosterior& posterior);

}  // namespace ertbench
