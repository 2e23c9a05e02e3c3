#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <tuple>

#include "forward/ellipses/ellipse_model.h"
#include "limit/annealed_sampler.h"
#include "limit/scene_likelihood.h"

namespace ertbench {
namespace {

constexpr double widest = 0.5;  ///< step of a quantity in domain units, rad, or of its own range
/// Largest drift in units of these widths: far from the posterior the slopes are unreliable.
constexpr double widest_drift = 0.5;
constexpr int most_quantities = 6;

bool has_aspect(DrawnShape shape) {
  return shape == DrawnShape::ellipse || shape == DrawnShape::rectangle;
}
bool has_angle(DrawnShape shape) {
  return shape != DrawnShape::disc && shape != DrawnShape::ring && shape != DrawnShape::cross;
}

/// The quantities of a contact that move beside its centre: the logarithm of its size, its
/// conductivity ratio, aspect and angle, each if it is free and its shape has it.
struct Freedom {
  bool size, ratio, aspect, angle;

  Freedom(const ContactDraw& contact, const ScenePrior& prior)
      : size(prior.size_is_free()),
        ratio(prior.ratio_is_free()),
        aspect(has_aspect(contact.shape) &&
               prior.distribution().aspect.first < prior.distribution().aspect.second),
        angle(has_angle(contact.shape)) {}
};

/// Largest steps of the quantities, in the order of Freedom.
Eigen::VectorXd widths_of(const SceneDraw& scene, const ScenePrior& prior) {
  const auto range = [](const std::pair<double, double>& interval) {
    return interval.second - interval.first;
  };
  const SceneDistribution& d = prior.distribution();
  Eigen::VectorXd widths(most_quantities * static_cast<Eigen::Index>(scene.size()));
  Eigen::Index at = 0;
  for (const ContactDraw& contact : scene) {
    const Freedom free(contact, prior);
    widths[at++] = widest;
    widths[at++] = widest;
    if (free.size) widths[at++] = widest;
    if (free.ratio) widths[at++] = widest * range(d.conductivity_ratio);
    if (free.aspect) widths[at++] = widest * range(d.aspect);
    if (free.angle) widths[at++] = widest;
  }
  widths.conservativeResize(at);
  return widths;
}

Eigen::Vector2d at_twice(double angle) { return {std::cos(2 * angle), std::sin(2 * angle)}; }

constexpr double wanted_acceptance = 0.3;
constexpr double joint_share = 0.5;        ///< of all moves, if there are joint ones
constexpr double number_share = 0.1;       ///< of the other moves, where the number is free
constexpr double log_narrowest_round = 3;  ///< widths of a round of chains: down to exp(-this)
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

/// The log likelihoods of things that have a fit.
template <class Things, class Fit>
Eigen::ArrayXd log_likelihoods(const Things& things, Fit fit_of) {
  Eigen::ArrayXd logs(std::ssize(things));
  for (Eigen::Index i = 0; i < logs.size(); ++i) {
    logs[i] = std::invoke(fit_of, things[static_cast<std::size_t>(i)]).log_likelihood;
  }
  return logs;
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

JointStep::JointStep(const ScenePrior& prior, const EllipseModel& model)
    : prior_(prior), model_(model), pairs_(reciprocal_pairs(model.sensor())) {}

Eigen::VectorXd JointStep::Local::draw(RandomStream& random) const {
  Eigen::VectorXd step(mean.size());
  for (double& value : step) value = random.normal();
  return mean + precision.matrixU().solve(step);
}

double JointStep::Local::log_density(const Eigen::VectorXd& step) const {
  const Eigen::VectorXd white = precision.matrixU() * (step - mean);
  return sum_of_logs(precision.matrixLLT().diagonal().array()) - white.squaredNorm() / 2;
}

bool JointStep::slopes_of(std::span<const EllipticContact> ellipses,
                          Eigen::Ref<Eigen::MatrixXd> out) {
  if (!model_.place(ellipses, workspace_)) return false;
  Eigen::VectorXd change(model_.pairs());
  model_.evaluate(workspace_, change);
  model_.derivatives(workspace_, out);
  return true;
}

std::optional<Eigen::MatrixXd> JointStep::slopes_of(const SceneDraw& scene,
                                                    std::span<const EllipticContact> ellipses) {
  const auto contacts = static_cast<Eigen::Index>(scene.size());
  Eigen::MatrixXd own(model_.pairs(), EllipticContact::parameters * contacts);
  if (!slopes_of(ellipses, own)) {
    // Ellipses that cross each other are linearised one by one.
    for (Eigen::Index c = 0; c < contacts; ++c) {
      auto columns = own.middleCols(EllipticContact::parameters * c, EllipticContact::parameters);
      if (!slopes_of(ellipses.subspan(static_cast<std::size_t>(c), 1), columns)) {
        return std::nullopt;
      }
    }
  }
  Eigen::MatrixXd out(model_.pairs(), most_quantities * contacts);
  Eigen::Index at = 0;
  for (Eigen::Index c = 0; c < contacts; ++c) {
    const ContactDraw& contact = scene[static_cast<std::size_t>(c)];
    const Freedom free(contact, prior_);
    const EllipticContact& ellipse = ellipses[static_cast<std::size_t>(c)];
    // Columns: derivatives by centre x, y, log size, stretch x, y, log ratio.
    const auto by = own.middleCols(EllipticContact::parameters * c, EllipticContact::parameters);
    const Eigen::Vector2d arm = ellipse.centre - contact.centre;
    out.col(at++) = by.col(0);
    out.col(at++) = by.col(1);
    if (free.size) out.col(at++) = by.col(2) + by.leftCols<2>() * arm;
    if (free.ratio) out.col(at++) = by.col(5) / contact.conductivity_ratio;
    if (free.aspect) {
      const double aspect = contact.aspect;
      double growth = 1 / (2 * aspect);
      // The corners of a rectangle stay on the circle.
      if (contact.shape == DrawnShape::rectangle) growth -= aspect / (1 + aspect * aspect);
      out.col(at++) =
          growth * by.col(2) - by.middleCols<2>(3) * (at_twice(contact.angle) / (2 * aspect));
    }
    if (free.angle) {
      const Eigen::Vector2d turned(-ellipse.stretch.y(), ellipse.stretch.x());
      out.col(at++) = by.middleCols<2>(3) * (2 * turned) +
                      by.leftCols<2>() * Eigen::Vector2d(-arm.y(), arm.x());
    }
  }
  out.conservativeResize(Eigen::NoChange, at);
  return out;
}

std::optional<JointStep::Local> JointStep::around(const SceneDraw& scene, const SceneFit& fit,
                                                  double heat, double scale) {
  if (scene.empty() || fit.rest.size() == 0) return std::nullopt;
  std::vector<EllipticContact> ellipses;
  for (const ContactDraw& contact : scene) {
    if (std::abs(1 - contact.conductivity_ratio) < 1e-6) return std::nullopt;
    ellipses.push_back(nearest_ellipse(contact_of(contact)));
  }
  const std::optional<Eigen::MatrixXd> by_quantity = slopes_of(scene, ellipses);
  if (!by_quantity) return std::nullopt;
  const Eigen::MatrixXd slopes = *by_quantity / fit.noise;
  Eigen::VectorXd rest(model_.pairs());
  Eigen::VectorXd weights(rest.size());  // the mean of two channels has half the variance of one
  for (Eigen::Index p = 0; p < rest.size(); ++p) {
    const auto [a, b] = pairs_[static_cast<std::size_t>(p)];
    rest[p] = (fit.rest[a] + fit.rest[b]) / 2;
    weights[p] = a == b ? 1 : 2;
  }
  const Eigen::VectorXd widths = widths_of(scene, prior_);
  Eigen::MatrixXd precision = heat * slopes.transpose() * weights.asDiagonal() * slopes;
  precision.diagonal().array() += 1 / widths.array().square();
  Local out;
  out.mean = precision.llt().solve(heat * slopes.transpose() * weights.asDiagonal() * rest) *
             (scale * scale / 2);
  const double farthest = (out.mean.array().abs() / widths.array()).maxCoeff();
  if (!std::isfinite(farthest)) return std::nullopt;
  out.mean *= std::min(1.0, widest_drift / std::max(farthest, 1e-300));
  out.precision.compute(precision / (scale * scale));
  return out;
}

std::pair<SceneDraw, double> JointStep::after(const SceneDraw& scene,
                                              const Eigen::VectorXd& step) const {
  SceneDraw out = scene;
  double log_sizes = 0;
  Eigen::Index at = 0;
  for (ContactDraw& contact : out) {
    const Freedom free(contact, prior_);
    contact.centre.x() += step[at++];
    contact.centre.y() += step[at++];
    if (free.size) {
      log_sizes += step[at];
      contact.size *= std::exp(step[at++]);
    }
    if (free.ratio) contact.conductivity_ratio += step[at++];
    if (free.aspect) contact.aspect += step[at++];
    if (free.angle) {
      // Angles are in 0 ... pi. Half a turn leaves an ellipse and a rectangle unchanged. It changes
      // a polygon, but the reverse step still leads back.
      contact.angle = std::fmod(contact.angle + step[at++], std::numbers::pi);
      if (contact.angle < 0) contact.angle += std::numbers::pi;
    }
  }
  return {out, log_sizes};
}

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
  const Eigen::ArrayXd logs = log_likelihoods(fits, std::identity());
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
    const Eigen::ArrayXd logs = log_likelihoods(particles_, &Particle::fit);
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

void AnnealingIsland::run_chains(const SceneDraw& drawn, std::vector<PosteriorSample>& samples) {
  heat_ = 1;
  number_moves_ = true;
  const Scene scene = scene_of(drawn);
  const SceneFit fit = likelihood_.of({&scene, 1}).front();
  particles_.assign(static_cast<std::size_t>(options_.particles),
                    {drawn, fit, prior_.log_density(drawn)});
  const int between = std::max(1, options_.final_rounds / options_.snapshots);
  for (int snapshot = 0; snapshot < options_.snapshots; ++snapshot) {
    for (int r = 0; r < between; ++r) {
      scales_.fill(std::exp(-log_narrowest_round * random_.uniform()));
      move(false);
    }
    int chain = 0;
    for (const Particle& p : particles_) samples.push_back({p.scene, p.fit, 1, chain++});
  }
}

std::size_t AnnealingIsland::particles_at(double heat) const {
  return static_cast<std::size_t>(options_.particles *
                                  std::clamp(1 / std::cbrt(heat), 1.0, most_particles));
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
    const bool number = number_moves_ && random_.uniform() < number_share;
    trial.kind = !number                   ? moves_.choose(random_)
                 : random_.uniform() < 0.5 ? Move::number
                                           : Move::split;
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
