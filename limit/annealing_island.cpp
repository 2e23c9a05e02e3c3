#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "limit/annealed_sampler.h"
#include "limit/scene_likelihood.h"

namespace ertbench {
namespace {

constexpr double wanted_acceptance = 0.3;
constexpr double joint_share = 0.5;  ///< of all moves, if there are joint ones
/// Factor on the number of scenes at the smallest powers, where positions are still uncertain and
/// voltages need not be accurate.
constexpr double most_particles = 4;
constexpr double least_heat_step = 1e-9;
constexpr double never_accurate_enough = -1e300;  ///< a threshold that no likelihood falls below

/// exp(logs - max), and the logarithm of their mean.
struct Weights {
  Eigen::ArrayXd values;
  double log_mean = 0;

  double effective() const { return values.sum() * values.sum() / values.square().sum(); }
};

Weights weights_of(const Eigen::ArrayXd& logs) {
  const double largest = logs.maxCoeff();
  Weights weights;
  weights.values = exp_of(logs - largest);
  weights.log_mean = largest + std::log(weights.values.mean());
  return weights;
}

/// The largest step of the power, at most `rest`, that leaves `effective` effective scenes.
double heat_step(const Eigen::ArrayXd& log_likelihoods, double rest, double effective) {
  if (weights_of(rest * log_likelihoods).effective() >= effective) return rest;
  double low = 0;
  double high = rest;
  while (high - low > 1e-3 * high && high > least_heat_step) {
    // Powers begin orders of magnitude below 1.
    const double middle = low > 0 ? std::sqrt(low * high) : high / 8;
    (weights_of(middle * log_likelihoods).effective() >= effective ? low : high) = middle;
  }
  return high;
}

/// Systematic resampling: returns `count` indices, each in proportion to its weight.
std::vector<std::size_t> resampled(const Eigen::ArrayXd& weights, std::size_t count,
                                   RandomStream& random) {
  std::vector<std::size_t> chosen;
  const double step = weights.sum() / static_cast<double>(count);
  double next = step * random.uniform();
  double sum = 0;
  for (Eigen::Index i = 0; i < weights.size() && chosen.size() < count; ++i) {
    sum += weights[i];
    while (next < sum && chosen.size() < count) {
      chosen.push_back(static_cast<std::size_t>(i));
      next += step;
    }
  }
  while (chosen.size() < count) chosen.push_back(static_cast<std::size_t>(weights.size() - 1));
  return chosen;
}

}  // namespace

AnnealingIsland::AnnealingIsland(const ScenePrior& prior, const SceneLikelihood& likelihood,
                                 const PlaceMetric& metric, JointStep* joint,
                                 const AnnealingOptions& options, RandomStream& random)
    : prior_(prior),
      likelihood_(likelihood),
      moves_(prior, metric),
      joint_(joint),
      options_(options),
      random_(random) {
  scales_.fill(1);
}

void AnnealingIsland::start(std::span<const SceneDraw> bank, std::span<const SceneFit> fits) {
  Eigen::ArrayXd logs(static_cast<Eigen::Index>(bank.size()));
  for (Eigen::Index i = 0; i < logs.size(); ++i) {
    logs[i] = fits[static_cast<std::size_t>(i)].log_likelihood;
  }
  heat_ = heat_step(
      logs, 1,
      std::min(most_particles * options_.particles, 0.5 * static_cast<double>(logs.size())));
  const std::size_t count = particles_at(heat_);
  const Weights weights = weights_of(heat_ * logs);
  log_evidence_ = weights.log_mean;
  for (const std::size_t i : resampled(weights.values, count, random_)) {
    particles_.push_back({bank[i], fits[i], prior_.log_density(bank[i])});
  }
  // The bank's voltages were computed at the lowest accuracy.
  std::vector<Scene> scenes;
  for (const Particle& p : particles_) scenes.push_back(scene_of(p.scene));
  const std::vector<SceneFit> better = likelihood_.of(scenes);
  for (std::size_t i = 0; i < better.size(); ++i) particles_[i].fit = better[i];
  solves_ += better.size();
}

void AnnealingIsland::anneal(double least) {
  for (;;) {
    const bool last = heat_ >= 1;
    if (!last && log_evidence_ + (1 - heat_) * likelihood_.largest() < least) {
      log_evidence_ = -std::numeric_limits<double>::infinity();
      return;
    }
    for (int r = 0; r < (last ? 0 : options_.rounds); ++r) move(true);
    if (last) return;
    const Eigen::ArrayXd logs = log_likelihoods();
    const double step =
        heat_step(logs, 1 - heat_, options_.least_share * static_cast<double>(logs.size()));
    const Weights weights = weights_of(step * logs);
    heat_ = step >= 1 - heat_ ? 1 : heat_ + step;
    log_evidence_ += weights.log_mean;
    std::vector<Particle> next;
    for (const std::size_t i : resampled(weights.values, particles_at(heat_), random_)) {
      next.push_back(particles_[i]);
    }
    particles_ = std::move(next);
  }
}

void AnnealingIsland::take(const AnnealingIsland& other) {
  particles_ = other.particles_;
  heat_ = other.heat_;
  scales_ = other.scales_;
}

void AnnealingIsland::collect(int island, double weight, std::vector<PosteriorSample>& samples) {
  for (int r = 0; r < options_.rounds; ++r) move(true);
  const int between = std::max(1, options_.final_rounds / options_.snapshots);
  weight /= static_cast<double>(options_.snapshots) * static_cast<double>(particles_.size());
  for (int snapshot = 0; snapshot < options_.snapshots; ++snapshot) {
    for (int r = 0; r < between; ++r) move(false);
    for (const Particle& p : particles_) samples.push_back({p.scene, p.fit, weight, island});
  }
}

std::size_t AnnealingIsland::particles_at(double heat) const {
  return static_cast<std::size_t>(options_.particles *
                                  std::clamp(1 / std::cbrt(heat), 1.0, most_particles));
}

Eigen::ArrayXd AnnealingIsland::log_likelihoods() const {
  Eigen::ArrayXd logs(static_cast<Eigen::Index>(particles_.size()));
  for (Eigen::Index i = 0; i < logs.size(); ++i) {
    logs[i] = particles_[static_cast<std::size_t>(i)].fit.log_likelihood;
  }
  return logs;
}

std::optional<AnnealingIsland::Trial> AnnealingIsland::tried(std::size_t i) {
  const Particle& p = particles_[i];
  Trial trial{i, Move::joint, {}, 0, 0, 0, {}};
  const bool joint = joint_ && random_.uniform() < joint_share;
  if (joint) {
    const auto local = joint_->around(p.scene, p.fit, heat_, scale_of(Move::joint));
    if (!local) return std::nullopt;
    trial.step = local->draw(random_);
    double log_sizes = 0;
    std::tie(trial.scene, log_sizes) = joint_->after(p.scene, trial.step);
    trial.log_ratio = log_sizes - local->log_density(trial.step);
  } else {
    trial.kind = moves_.choose(random_);
    std::optional<Proposal> proposal =
        moves_.propose(trial.kind, p.scene, scale_of(trial.kind), heat_, random_);
    if (!proposal) return std::nullopt;
    trial.scene = std::move(proposal->scene);
    trial.log_ratio = proposal->log_ratio;
  }
  trial.log_prior = prior_.log_density(trial.scene);
  trial.log_chance = std::log(1 - random_.uniform());
  return trial;
}

double AnnealingIsland::threshold_of(const Trial& trial) const {
  const Particle& p = particles_[trial.particle];
  return p.fit.log_likelihood +
         (trial.log_chance - trial.log_ratio - trial.log_prior + p.log_prior) / heat_;
}

bool AnnealingIsland::complete(Trial& trial, const SceneFit& fit) {
  if (trial.kind != Move::joint) return true;
  const auto back = joint_->around(trial.scene, fit, heat_, scale_of(Move::joint));
  if (!back) return false;
  trial.log_ratio += back->log_density(-trial.step);
  return true;
}

void AnnealingIsland::move(bool adapt) {
  std::vector<Trial> trials;
  std::vector<double> thresholds;
  std::vector<Scene> scenes;
  std::array<int, move_count> made{};
  std::array<int, move_count> taken{};
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    std::optional<Trial> trial = tried(i);
    if (!trial) continue;
    ++made[static_cast<std::size_t>(trial->kind)];
    if (!std::isfinite(trial->log_prior)) continue;
    scenes.push_back(scene_of(trial->scene));
    // The reverse density of a joint step depends on the voltages, which must always be accurate.
    thresholds.push_back(trial->kind == Move::joint ? never_accurate_enough : threshold_of(*trial));
    trials.push_back(std::move(*trial));
  }
  if (trials.empty()) return;
  const std::vector<SceneFit> fits = likelihood_.of(scenes, thresholds);
  solves_ += trials.size();
  for (std::size_t t = 0; t < trials.size(); ++t) {
    Trial& trial = trials[t];
    if (!complete(trial, fits[t])) continue;
    if (!(fits[t].log_likelihood > threshold_of(trial))) continue;
    particles_[trial.particle] = {std::move(trial.scene), fits[t], trial.log_prior};
    ++taken[static_cast<std::size_t>(trial.kind)];
  }
  for (std::size_t k = 0; adapt && k < scales_.size(); ++k) {
    if (made[k] == 0) continue;
    const double more = taken[k] - wanted_acceptance * made[k];
    const double step = std::min(1.0, made[k] / 8.0) * more / made[k];
    scales_[k] = std::clamp(scales_[k] * std::exp(step), 1e-4, 2.0);
  }
}

}  // namespace ertbench
