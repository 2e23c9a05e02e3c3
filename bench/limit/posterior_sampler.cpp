#include "bench/limit/posterior_sampler.h"

#include <algorithm>
#include <cmath>

#include "core/errors.h"

namespace ertbench {
namespace {

constexpr std::size_t annealing_bank = 24000;
constexpr std::size_t importance_bank = 4000;
constexpr int importance_points = 4000;
constexpr int pilot_points = 400;
constexpr int corrected_scenes = 24;
constexpr int lattice_of_discs = 56;
constexpr double least_left = 0.5;  ///< of the samples in force, by other weights

SamplerKind best_sampler(const ScenePrior& prior, const SceneVoltages& voltages) {
  if (is_enumerable(prior, voltages)) return SamplerKind::enumeration;
  if (is_one_disc(prior) && voltages.is_smooth()) return SamplerKind::importance;
  return SamplerKind::annealing;
}

bool allows(SamplerKind kind, const ScenePrior& prior, const SceneVoltages& voltages) {
  if (kind == SamplerKind::enumeration) return is_enumerable(prior, voltages);
  if (kind == SamplerKind::importance) return is_one_disc(prior) && voltages.is_smooth();
  return true;
}

double kish(const std::vector<PosteriorSample>& samples) {
  double sum = 0;
  double squares = 0;
  for (const PosteriorSample& sample : samples) {
    sum += sample.weight;
    squares += sample.weight * sample.weight;
  }
  return squares > 0 ? sum * sum / squares : 0;
}

/// Of as many as an oracle could draw none is unknown to the other prior.
bool has_all_of(const ScenePrior& outer, const ScenePrior& inner) {
  constexpr int scenes = 1000;
  RandomStream random(1, key_of("support"), 0, Purpose::scene);
  for (int i = 0; i < scenes; ++i) {
    if (!std::isfinite(outer.log_density(inner.draw(random)))) return false;
  }
  return true;
}

}  // namespace

const std::vector<std::string>& names_of_samplers() {
  static const std::vector<std::string> names = {"auto", "enumeration", "importance", "annealing"};
  return names;
}

SamplerKind resolved(SamplerKind kind, const ScenePrior& prior, const SceneVoltages& voltages) {
  return kind == SamplerKind::automatic ? best_sampler(prior, voltages) : kind;
}

PosteriorSampler::PosteriorSampler(const DatasetSpec& spec, const ScenePrior& prior,
                                   const SceneVoltages& voltages, SamplerKind kind, int threads)
    : spec_(spec), prior_(prior), voltages_(voltages), kind_(resolved(kind, prior, voltages)) {
  if (!allows(kind_, prior_, voltages_)) {
    throw InputError("--sampler " + name() + ": the scenes of \"" + spec.name +
                     "\" do not allow it (importance: one disc and smooth voltages; enumeration: "
                     "one disc of one size and strength, pixels filled by their centres); leave "
                     "--sampler out");
  }
  if (kind_ == SamplerKind::enumeration) {
    const int side = std::get<GridSheet>(spec.model).side;
    enumerated_ = std::make_unique<EnumeratedDiscs>(prior_, spec.sensor, voltages_, side,
                                                    lattice_of_discs, threads);
    return;
  }
  if (has_other_model(spec)) own_ = std::make_unique<SceneModel>(spec.sensor, spec.model);
  RandomStream random(1, key_of("limit bank of " + spec.name), 0, Purpose::scene);
  const bool annealing = kind_ == SamplerKind::annealing;
  bank_ =
      draw_bank(prior_, voltages_, annealing ? annealing_bank : importance_bank, random, threads);
  if (!annealing) return;
  if (voltages_.is_smooth()) ellipses_ = std::make_unique<EllipseModel>(spec.sensor);
  const double channels = static_cast<double>(spec.sensor.channels());
  std::vector<double> noise;
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(bank_.voltages.rows(), 201); ++i) {
    noise.push_back(
        noise_norm(spec.noise, voltages_.reference(), bank_.voltages.row(i).transpose()) /
        std::sqrt(channels));
  }
  std::nth_element(noise.begin(), noise.begin() + static_cast<std::ptrdiff_t>(noise.size() / 2),
                   noise.end());
  metric_ = std::make_unique<PlaceMetric>(
      spec.sensor, std::max(noise[noise.size() / 2], 1e-12 * voltages_.reference().norm()));
}

std::string PosteriorSampler::name() const {
  return names_of_samplers()[static_cast<std::size_t>(kind_)];
}

PosteriorSamples PosteriorSampler::sampled(const Eigen::VectorXd& frame, int effort, bool pilot,
                                           double* pareto_k, RandomStream& random) const {
  const FrameLikelihood likelihood(voltages_, spec_.noise, frame);
  if (kind_ == SamplerKind::enumeration) return enumerated_->posterior(likelihood);
  const std::vector<SceneFit> fits = likelihood.of_voltages(bank_.voltages);
  if (kind_ == SamplerKind::importance) {
    WeightedPoints quality;
    PosteriorSamples out = sample_disc_by_importance(
        prior_, likelihood, bank_.scenes, fits, pilot ? pilot_points : effort * importance_points,
        random, &quality);
    *pareto_k = quality.pareto_k;
    return out;
  }
  AnnealingOptions options;
  options.rounds *= effort;
  options.final_rounds *= effort;
  if (pilot)
    options = {.islands = 1, .particles = 24, .rounds = 6, .final_rounds = 6, .snapshots = 1};
  return sample_by_annealing(prior_, likelihood, *metric_, ellipses_.get(), bank_.scenes, fits,
                             options, random);
}

Eigen::VectorXd PosteriorSampler::corrected(const Eigen::VectorXd& frame,
                                            const PosteriorSamples& found,
                                            RandomStream& random) const {
  double sum = 0;
  for (const PosteriorSample& sample : found.samples) sum += sample.weight;
  // As many by their weights, at equal steps.
  std::vector<Scene> scenes;
  const double offset = random.uniform();
  double passed = 0;
  for (const PosteriorSample& sample : found.samples) {
    passed += sample.weight;
    const double steps_passed = passed / sum * corrected_scenes;
    while (offset + static_cast<double>(scenes.size()) < steps_passed) {
      scenes.push_back(scene_of(sample.scene));
    }
  }
  const std::vector<std::uint64_t> numbers(scenes.size(), 0);
  Frames exact(static_cast<Eigen::Index>(scenes.size()), frame.size());
  RowMajorMatrix effort(exact.rows(), 2);
  own_->solve(spec_, scenes, numbers, exact, effort);
  const Frames quick = FrameLikelihood(voltages_, spec_.noise, frame).voltages_of(scenes);
  return frame - (exact - quick).colwise().mean().transpose();
}

SampledPosterior PosteriorSampler::sample(const Eigen::VectorXd& frame, int effort,
                                          const SampledPosterior* before,
                                          RandomStream& random) const {
  SampledPosterior out;
  Eigen::VectorXd explained = frame;
  if (own_) {
    double pareto_k = 0;
    explained = corrected(
        frame, before ? before->samples : sampled(frame, 1, true, &pareto_k, random), random);
  }
  out.samples = sampled(explained, effort, false, &out.pareto_k, random);
  return out;
}

bool reweight(const ScenePrior& from, const ScenePrior& to, SampledPosterior& posterior) {
  if (!from.is_comparable(to) || !has_all_of(from, to)) return false;
  std::vector<PosteriorSample> weighted;
  for (PosteriorSample sample : posterior.samples.samples) {
    const double log = to.log_density(sample.scene) - from.log_density(sample.scene);
    if (!std::isfinite(log)) continue;
    sample.weight *= std::exp(log);
    weighted.push_back(std::move(sample));
  }
  if (kish(weighted) < least_left * kish(posterior.samples.samples)) return false;
  posterior.samples.samples = std::move(weighted);
  return true;
}

}  // namespace ertbench
