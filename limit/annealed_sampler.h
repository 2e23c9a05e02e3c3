#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/random.h"
#include "forward/ellipses/ellipse_model.h"
#include "limit/scene_likelihood.h"
#include "limit/scene_prior.h"

namespace ertbench {

/// Steps of all contacts of a scene together, along what the frame's rest asks for and as wide as
/// the frame allows: the Metropolis-adjusted Langevin step in the metric of the Fisher information,
/// simplified (Girolami and Calderhead 2011). Its slopes are those of the ellipses nearest to the
/// contacts, so that a step costs a small part of a forward solution; that they are not the slopes
/// of the contacts themselves costs acceptance and nothing else.
///
/// One object serves one thread.
class JointStep {
 public:
  /// All must outlive this.
  JointStep(const ScenePrior& prior, const EllipseModel& model);

  /// The normal distribution of the steps from a scene.
  struct Local {
    Eigen::VectorXd mean;
    Eigen::LLT<Eigen::MatrixXd> precision;

    Eigen::VectorXd draw(RandomStream& random) const;
    double log_density(const Eigen::VectorXd& step) const;  ///< up to a constant of its length
  };

  /// From `scene`, which explains its frame as `fit` says. `heat`: the power of the likelihood in
  /// the target, 0 ... 1; `scale`: of the steps, 1 for those as wide as the target. Nothing where
  /// the fit has no rest, or an ellipse crosses the sheet's border.
  std::optional<Local> around(const SceneDraw& scene, const SceneFit& fit, double heat,
                              double scale);
  /// The scene after a step, and the logarithm of the derivative of its sizes by their logarithms
  /// over that before it.
  std::pair<SceneDraw, double> after(const SceneDraw& scene, const Eigen::VectorXd& step) const;

 private:
  /// [pairs, quantities] V per unit; `ellipses` [contacts] are the scene's. Nothing where one of
  /// them crosses the sheet's border.
  std::optional<Eigen::MatrixXd> slopes_of(const SceneDraw& scene,
                                           std::span<const EllipticContact> ellipses);
  /// By the parameters of the ellipses together; false where they cross.
  bool slopes_of(std::span<const EllipticContact> ellipses, Eigen::Ref<Eigen::MatrixXd> out);

  const ScenePrior& prior_;
  const EllipseModel& model_;
  std::vector<std::array<int, 2>> pairs_;
  EllipseModel::Workspace workspace_;
};

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

/// Scenes of one prior that are moved and drawn anew while the power of the likelihood rises from 0
/// to 1: one of the independent samplers of sample_by_annealing().
class AnnealingIsland {
 public:
  /// All must outlive this; `joint` may be null.
  AnnealingIsland(const ScenePrior& prior, const SceneLikelihood& likelihood,
                  const PlaceMetric& metric, JointStep* joint, const AnnealingOptions& options,
                  RandomStream& random);

  /// From scenes of the prior, with their likelihoods.
  void start(std::span<const SceneDraw> bank, std::span<const SceneFit> fits);
  /// Until the power is 1, or until it is certain that the log evidence will be below `least`: then
  /// it is minus infinity, and there is nothing to collect.
  void anneal(double least);
  /// Goes on with the scenes of another island, where that is.
  void take(const AnnealingIsland& other);
  /// Moves at the posterior itself, with snapshots between, whose scenes share `weight` out.
  void collect(int island, double weight, std::vector<PosteriorSample>& samples);

  double log_evidence() const { return log_evidence_; }
  std::uint64_t solves() const { return solves_; }

 private:
  struct Particle {
    SceneDraw scene;
    SceneFit fit;
    double log_prior = 0;
  };

  /// What is tried for one particle.
  struct Trial {
    std::size_t particle;
    Move kind;
    SceneDraw scene;
    double log_prior;
    double log_chance;     ///< of a uniform number: what the ratio of acceptance must exceed
    double log_ratio;      ///< of Proposal; of a joint step without the way back
    Eigen::VectorXd step;  ///< of a joint step
  };

  Eigen::ArrayXd log_likelihoods() const;
  /// Scenes at a power of the likelihood.
  std::size_t particles_at(double heat) const;
  std::optional<Trial> tried(std::size_t particle);
  double& scale_of(Move kind) { return scales_[static_cast<std::size_t>(kind)]; }
  /// The log likelihood that a trial's scene must exceed.
  double threshold_of(const Trial& trial) const;
  /// Adds the way back to a joint step's ratio; false where there is none.
  bool complete(Trial& trial, const SceneFit& fit);
  /// One move of every scene.
  void move(bool adapt);

  const ScenePrior& prior_;
  const SceneLikelihood& likelihood_;
  SceneMoves moves_;
  JointStep* joint_;
  const AnnealingOptions& options_;
  RandomStream& random_;
  MoveScales scales_{};
  std::vector<Particle> particles_;
  double heat_ = 0;
  double log_evidence_ = 0;
  std::uint64_t solves_ = 0;
};

}  // namespace ertbench
