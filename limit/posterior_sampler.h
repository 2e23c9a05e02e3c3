#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/random.h"
#include "forward/data/scene_model.h"
#include "limit/annealed_sampler.h"

namespace ertbench {

/// A posterior over a few numbers with one or more approximately Gaussian modes.
struct LaplaceProblem {
  Eigen::VectorXd low, high;  ///< [dimension] the box that bounds the support
  /// Residuals, [any], whose sum of squares is approximately -2 log of the likelihood.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  /// Exact logarithm of the target up to a constant; -infinity outside its support.
  std::function<std::vector<double>(std::span<const Eigen::VectorXd>)> log_target;
};

struct WeightedPoints {
  std::vector<Eigen::VectorXd> points;
  Eigen::VectorXd weights;  ///< [points], adding up to 1
  double pareto_k = 0;      ///< shape of the tail of the weights; above .7 estimates are unreliable
  double effective = 0;     ///< Kish's effective number of points
  std::size_t modes = 0;
};

/// Importance sampling from the Laplace approximation. Levenberg-Marquardt from every start finds
/// the modes; the proposal is a mixture of Student distributions around them and, as a defence, a
/// tenth of uniform points, refitted a few times to the moments of its points. The weights are
/// smoothed (pareto_smoothed).
WeightedPoints sample_by_importance(const LaplaceProblem& problem,
                                    std::span<const Eigen::VectorXd> starts, int points,
                                    RandomStream& random);

/// Replaces the largest weights by the expected order statistics of a generalised Pareto
/// distribution fitted to them (PSIS: Vehtari et al. 2024; fit by Zhang and Stephens 2009) and
/// returns its shape k. Fewer than 25 weights are left unchanged.
double pareto_smoothed(Eigen::VectorXd& weights);

/// Samples the posterior under a prior whose scenes are single discs. The likelihood's voltages
/// must be smooth. Starts are the best of `bank`, whose fits are `bank_fits`.
PosteriorSamples sample_disc_by_importance(const ScenePrior& prior,
                                           const FrameLikelihood& likelihood,
                                           std::span<const SceneDraw> bank,
                                           std::span<const SceneFit> bank_fits, int points,
                                           RandomStream& random);

/// True if every scene of the prior is a single disc.
bool is_one_disc(const ScenePrior& prior);

/// All images that a disc of one size and conductivity can have if pixels are filled by their
/// centres, each with its positions and voltages. The posterior over them is a finite sum, without
/// sampling and without derivatives, which do not exist here.
class EnumeratedDiscs {
 public:
  /// `voltages` must fill pixels of a grid of `side` by their centres. Positions are those of a
  /// lattice of `lattice` points per pixel in x and in y.
  EnumeratedDiscs(const ScenePrior& prior, const Sensor& sensor, const SceneVoltages& voltages,
                  int side, int lattice, int threads);

  /// Positions of all images with a noticeable weight; those of one image divide its weight.
  PosteriorSamples posterior(const FrameLikelihood& likelihood) const;

 private:
  ContactDraw disc_;
  std::vector<std::vector<Eigen::Vector2d>> places_;  ///< [images]
  Frames voltages_;                                   ///< [images, channels] V
};

/// True if EnumeratedDiscs applies: one disc, of which only the position is free.
bool is_enumerable(const ScenePrior& prior, const SceneVoltages& voltages);

/// `automatic` takes the most exact sampler that the scenes allow.
enum class SamplerKind { automatic, enumeration, importance, annealing };

const std::vector<std::string>& names_of_samplers();  ///< in the order of the enumeration

/// The sampler that `automatic` stands for with these scenes; any other kind unchanged.
SamplerKind resolved(SamplerKind kind, const ScenePrior& prior, const SceneVoltages& voltages);

/// Samples posteriors of the frames of one set under one prior. The constructor prepares what all
/// frames share: scenes of the prior with their voltages, or all possible images.
///
/// const functions are thread-safe.
class PosteriorSampler {
 public:
  /// Throws InputError if the set's scenes do not allow the sampler. `voltages` must outlive this.
  PosteriorSampler(const DatasetSpec& spec, const ScenePrior& prior, const SceneVoltages& voltages,
                   SamplerKind kind, int threads);

  std::string name() const;

  /// `frame` [channels] V. `effort`: factor on the work, from 1. `before`: the result of an earlier
  /// call for the frame, or null. If the set's own model differs from the likelihood's, the
  /// difference is computed at the scenes of `before` or of a short first run.
  PosteriorSamples sample(const Eigen::VectorXd& frame, int effort, const PosteriorSamples* before,
                          RandomStream& random) const;
  /// The same without that correction.
  PosteriorSamples sample_uncorrected(const Eigen::VectorXd& frame, RandomStream& random) const {
    return sampled(frame, 1, false, random);
  }
  const PlaceMetric& metric() const { return *metric_; }  ///< of annealing

 private:
  PosteriorSamples sampled(const Eigen::VectorXd& frame, int effort, bool pilot,
                           RandomStream& random) const;
  /// The frame minus the mean difference of the set's own model and the likelihood's over some of
  /// the scenes of `found`, [channels] V.
  Eigen::VectorXd corrected(const Eigen::VectorXd& frame, const PosteriorSamples& found,
                            RandomStream& random) const;

  DatasetSpec spec_;
  ScenePrior prior_;
  const SceneVoltages& voltages_;
  SamplerKind kind_;
  SceneBank bank_;
  std::unique_ptr<PlaceMetric> metric_;
  std::unique_ptr<EllipseModel> ellipses_;  ///< for joint steps, if voltages are smooth
  std::unique_ptr<EnumeratedDiscs> enumerated_;
  std::unique_ptr<SceneModel> own_;  ///< the set's, if the likelihood's model differs
};

/// Reweights samples under `from` to samples under `to` and returns true. Returns false and leaves
/// them unchanged if `from` does not cover `to` or too few effective samples would be left.
bool reweight(const ScenePrior& from, const ScenePrior& to, PosteriorSamples& posterior);

}  // namespace ertbench
