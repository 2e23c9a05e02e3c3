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

/// Steps of all contacts of a scene together: a simplified Metropolis-adjusted Langevin step in the
/// metric of the Fisher information (Girolami and Calderhead 2011). Derivatives are those of the
/// ellipses nearest to the contacts, so that a step costs a small part of a forward solution; the
/// approximation lowers the acceptance and introduces no bias.
///
/// One object serves one thread.
class JointStep {
 public:
  /// All must outlive this.
  JointStep(const ScenePrior& prior, const EllipseModel& model);

  /// Normal distribution of the steps from a scene.
  struct Local {
    Eigen::VectorXd mean;
    Eigen::LLT<Eigen::MatrixXd> precision;

    Eigen::VectorXd draw(RandomStream& random) const;
    double log_density(const Eigen::VectorXd& step) const;  ///< up to a constant
  };

  /// Steps from `scene`, whose fit to the frame is `fit`. `heat`: the power of the likelihood in
  /// the target, 0 ... 1; `scale`: width of the steps, 1 for that of the target. Nothing if the fit
  /// has no rest or an ellipse crosses the sheet's border.
  std::optional<Local> around(const SceneDraw& scene, const SceneFit& fit, double heat,
                              double scale);
  /// The scene after a step, and the log ratio of its sizes to those before: the Jacobian of
  /// stepping in the logarithm of the sizes.
  std::pair<SceneDraw, double> after(const SceneDraw& scene, const Eigen::VectorXd& step) const;

 private:
  /// [pairs, quantities] V per unit; `ellipses` [contacts] are the scene's. Nothing if one of them
  /// crosses the sheet's border.
  std::optional<Eigen::MatrixXd> slopes_of(const SceneDraw& scene,
                                           std::span<const EllipticContact> ellipses);
  /// Derivatives by the ellipses' parameters; false if the ellipses cross.
  bool slopes_of(std::span<const EllipticContact> ellipses, Eigen::Ref<Eigen::MatrixXd> out);

  const ScenePrior& prior_;
  const EllipseModel& model_;
  std::vector<std::array<int, 2>> pairs_;
  EllipseModel::Workspace workspace_;
};

struct PosteriorSample {
  SceneDraw scene;
  SceneFit fit;
  double weight = 1;  ///< relative to the others
  int island = 0;     ///< the independent sampler it descends from
};

struct PosteriorSamples {
  std::vector<PosteriorSample> samples;
  std::vector<double> log_evidence;  ///< [islands]
  /// True if only one of several islands found the scenes that explain the frame best; further
  /// modes may have been missed then.
  bool alone = false;
  /// True if all samples descend from one island, because its scenes were much better than the
  /// others'. `island` then counts copies, which are not independent.
  bool one_origin = false;
  double pareto_k = 0;       ///< see WeightedPoints; importance sampling only
  std::uint64_t solves = 0;  ///< number of scenes solved
};

/// Scenes drawn from a prior, among which every frame finds its starting points: the first part of
/// the annealing, done once for a whole set.
struct SceneBank {
  std::vector<SceneDraw> scenes;
  Frames voltages;  ///< [scenes, channels] V; empty if the likelihood needs none
};

struct AnnealingOptions {
  int islands = 4;           ///< independent samplers, whose spread gives the error
  int particles = 20;        ///< scenes per island and number of contacts; up to 4 times at first
  int rounds = 32;           ///< moves of each scene at each temperature
  int final_rounds = 192;    ///< moves at the last temperature
  int snapshots = 12;        ///< number of times the scenes enter the result
  double least_share = 0.5;  ///< share of effective scenes that a new temperature must leave
};

/// Sequential Monte Carlo over scenes (Del Moral, Doucet, Jasra 2006) from the prior to the
/// posterior through increasing powers of the likelihood, each chosen to leave a share of the
/// scenes effective, with moves (SceneMoves) and, given `ellipses`, joint ones (JointStep) at each
/// power. Each number of contacts has its own scenes, which are weighted by its evidence at the
/// end, since moves that add or remove a contact are no longer accepted at high powers. Sampling
/// starts from the prior alone, never from a truth. An island with less evidence for a number of
/// contacts than another continues from the other's scenes, and both share the mean of their
/// evidences; numbers of contacts that cannot explain the frame are given up early. Deterministic:
/// `random` is the only source of randomness.
///
/// `bank_fits` [bank] are the fits of the bank's scenes, which are divided among the islands.
PosteriorSamples sample_by_annealing(const ScenePrior& prior, const SceneLikelihood& likelihood,
                                     const PlaceMetric& metric, const EllipseModel* ellipses,
                                     std::span<const SceneDraw> bank,
                                     std::span<const SceneFit> bank_fits,
                                     const AnnealingOptions& options, RandomStream& random);

/// Draws a bank from a prior and solves it.
SceneBank draw_bank(const ScenePrior& prior, const SceneVoltages& voltages, std::size_t scenes,
                    RandomStream& random, int threads);

/// One of the independent samplers of sample_by_annealing(): scenes of one prior that are moved and
/// resampled while the power of the likelihood rises from 0 to 1.
class AnnealingIsland {
 public:
  /// All must outlive this; `joint` may be null.
  AnnealingIsland(const ScenePrior& prior, const SceneLikelihood& likelihood,
                  const PlaceMetric& metric, JointStep* joint, const AnnealingOptions& options,
                  RandomStream& random);

  /// Starts from scenes of the prior with their fits.
  void start(std::span<const SceneDraw> bank, std::span<const SceneFit> fits);
  /// Anneals until the power is 1, or until the log evidence must end below `least`; it is then set
  /// to minus infinity and there is nothing to collect.
  void anneal(double least);
  /// Continues with the scenes of another island.
  void take(const AnnealingIsland& other);
  /// Moves at the posterior itself and appends snapshots, whose scenes divide `weight`.
  void collect(int island, double weight, std::vector<PosteriorSample>& samples);
  /// Runs `particles` chains at the posterior itself from a scene that was drawn from it, and
  /// appends snapshots, the chains in turn, whose `island` is the chain. Given the scene the chains
  /// are independent. Every sample has the posterior's distribution: the widths of the moves are
  /// drawn for each round and adapt to nothing, and the number of contacts moves, too.
  void run_chains(const SceneDraw& drawn, std::vector<PosteriorSample>& samples);

  double log_evidence() const { return log_evidence_; }
  std::uint64_t solves() const { return solves_; }

 private:
  struct Particle {
    SceneDraw scene;
    SceneFit fit;
    double log_prior = 0;
  };

  /// A proposed move of one particle.
  struct Trial {
    std::size_t particle;
    Move kind;
    SceneDraw scene;
    double log_prior;
    double log_chance;     ///< log of a uniform number that the acceptance ratio must exceed
    double log_ratio;      ///< as in Proposal; for a joint step without the reverse density
    Eigen::VectorXd step;  ///< a joint step's
  };

  /// Number of scenes at a power of the likelihood.
  std::size_t particles_at(double heat) const;
  std::optional<Trial> tried(std::size_t particle);
  double& scale_of(Move kind) { return scales_[static_cast<std::size_t>(kind)]; }
  /// The log likelihood that a trial's scene must exceed to be accepted.
  double threshold_of(const Trial& trial) const;
  /// Adds the reverse density to a joint step's ratio; false if the reverse step is impossible.
  bool complete(Trial& trial, const SceneFit& fit);
  /// Moves every scene once; `adapt` also adapts the moves' widths.
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
  bool number_moves_ = false;
  double log_evidence_ = 0;
  std::uint64_t solves_ = 0;
};

}  // namespace ertbench
