#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bench/limit/annealed_sampler.h"
#include "bench/limit/joint_step.h"
#include "bench/limit/scene_moves.h"

namespace ertbench {

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
