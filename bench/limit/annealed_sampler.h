#pragma once

#include <span>
#include <vector>

#include "bench/limit/joint_step.h"
#include "bench/limit/scene_likelihood.h"
#include "bench/limit/scene_moves.h"
#include "bench/limit/scene_prior.h"

namespace ertbench {

/// One scene out of a posterior.
struct PosteriorSample {
  SceneDraw scene;
  SceneFit fit;
  double weight = 1;  ///< relative to the others
  int island = 0;     ///< the independent sampler that it descends from
};

struct PosteriorSamples {
  std::vector<PosteriorSample> samples;
  std::vector<double> log_evidence;  ///< of each island
  /// Of several islands one alone found the scenes that explain the frame best, so that nothing
  /// says what it missed.
  bool alone = false;
  /// All samples descend from one island's, whose scenes were so much better than the others' that
  /// these went on from them: `island` tells the copies apart, which are not independent.
  bool one_origin = false;
  std::uint64_t solves = 0;  ///< scenes that were computed for it
};

/// Scenes drawn from a prior, of which every frame takes those that explain it as its start: the
/// hot part of the annealing, done once for a whole set.
struct SceneBank {
  std::vector<SceneDraw> scenes;
  Frames voltages;  ///< [scenes, channels] V; empty for likelihoods that need none
};

struct AnnealingOptions {
  int islands = 4;           ///< independent samplers, which the error is told from
  int particles = 20;        ///< scenes of each and each number of contacts; up to 4 times at first
  int rounds = 32;           ///< moves of each scene at a temperature
  int final_rounds = 192;    ///< at the last
  int snapshots = 12;        ///< in which the scenes enter the result
  double least_share = 0.5;  ///< of the effective scenes that a new temperature leaves
};

/// Sequential Monte Carlo over scenes (Del Moral, Doucet, Jasra 2006): from the prior to the
/// posterior through powers of the likelihood, chosen so that each leaves a share of the scenes in
/// force, with moves (SceneMoves) and, given `ellipses`, joint ones (JointStep) at each power. Each
/// number of contacts has scenes of its own, weighted in the end by its evidence: which number it
/// is shows at powers at which no scene gains or loses a contact any more. Starts from the prior
/// alone, never from a truth. An island that found less evidence for a number of contacts than
/// another goes on from the other's scenes, and both share the mean of their evidences; numbers of
/// contacts that cannot explain the frame are given up on the way. Deterministic: `random` is its
/// only source.
///
/// `bank_fits` [bank] are the likelihoods of the bank's scenes, shared out among the islands.
PosteriorSamples sample_by_annealing(const ScenePrior& prior, const SceneLikelihood& likelihood,
                                     const PlaceMetric& metric, const EllipseModel* ellipses,
                                     std::span<const SceneDraw> bank,
                                     std::span<const SceneFit> bank_fits,
                                     const AnnealingOptions& options, RandomStream& random);

/// The bank of a prior, with voltages.
SceneBank draw_bank(const ScenePrior& prior, const SceneVoltages& voltages, std::size_t scenes,
                    RandomStream& random, int threads);

}  // namespace ertbench
