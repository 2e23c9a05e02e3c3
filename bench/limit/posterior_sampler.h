#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "bench/limit/annealed_sampler.h"
#include "bench/limit/disc_importance.h"
#include "bench/limit/enumerated_discs.h"
#include "forward/data/scene_model.h"

namespace ertbench {

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
