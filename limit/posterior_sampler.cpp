#include "limit/posterior_sampler.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "core/errors.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int importance_starts = 24;
constexpr double smallest_part = 1e-9;  ///< of the posterior, for an image to be kept
constexpr std::size_t most_places_of_image = 24;

constexpr std::size_t annealing_bank = 24000;
constexpr std::size_t importance_bank = 4000;
constexpr int importance_points = 4000;
constexpr int pilot_points = 400;
constexpr int corrected_scenes = 24;
constexpr int lattice_of_discs = 56;
constexpr double least_left = 0.5;  ///< share of the effective samples that reweighting must keep

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

/// True if the outer prior can draw every scene of a sample from the inner one.
bool has_all_of(const ScenePrior& outer, const ScenePrior& inner) {
  constexpr int scenes = 1000;
  RandomStream random(1, key_of("support"), 0, Purpose::scene);
  for (int i = 0; i < scenes; ++i) {
    if (!std::isfinite(outer.log_density(inner.draw(random)))) return false;
  }
  return true;
}

}  // namespace

bool is_one_disc(const ScenePrior& prior) {
  const SceneDistribution& d = prior.distribution();
  return d.contacts == std::pair(1, 1) && d.blank_fraction == 0 &&
         d.shapes == std::vector{DrawnShape::disc} && !d.centre;
}

PosteriorSamples sample_disc_by_importance(const ScenePrior& prior,
                                           const FrameLikelihood& likelihood,
                                           std::span<const SceneDraw> bank,
                                           std::span<const SceneFit> bank_fits, int points,
                                           RandomStream& random) {
  const SceneDistribution& d = prior.distribution();
  const bool sizes = prior.size_is_free();
  const bool ratios = prior.ratio_is_free();
  const Index dimension = 2 + (sizes ? 1 : 0) + (ratios ? 1 : 0);
  const double margin = d.inside ? d.radius.first : 0;
  LaplaceProblem problem;
  problem.low.resize(dimension);
  problem.high.resize(dimension);
  problem.low.head<2>() = prior.sheet().bounds().min().array() + margin;
  problem.high.head<2>() = prior.sheet().bounds().max().array() - margin;
  // Voltages determine the strength, a combination of size and conductivity. It replaces the size
  // as a coordinate, in which the posterior is not a crescent.
  const auto log_strength = [](double size, double ratio) {
    return 2 * std::log(size) + std::log(std::abs(1 - ratio) / (1 + ratio));
  };
  const bool strengths = sizes && ratios && d.conductivity_ratio.second < 1;
  if (sizes) {
    const auto [low, high] = d.conductivity_ratio;
    problem.low[2] = strengths ? log_strength(d.radius.first, high) : d.radius.first;
    problem.high[2] = strengths ? log_strength(d.radius.second, low) : d.radius.second;
  }
  if (ratios) {
    problem.low[dimension - 1] = d.conductivity_ratio.first;
    problem.high[dimension - 1] = d.conductivity_ratio.second;
  }
  const auto draw_of = [&](const VectorXd& at) {
    ContactDraw disc;
    disc.centre = at.head<2>();
    disc.size = sizes ? at[2] : d.radius.first;
    disc.conductivity_ratio = ratios ? at[dimension - 1] : d.conductivity_ratio.first;
    if (strengths) disc.size = std::exp((at[2] - log_strength(1, disc.conductivity_ratio)) / 2);
    disc.aspect = d.aspect.first;
    return SceneDraw{disc};
  };
  const auto numbers_of = [&](const ContactDraw& disc) {
    VectorXd at(dimension);
    at.head<2>() = disc.centre;
    if (sizes) at[2] = disc.size;
    if (strengths) at[2] = log_strength(disc.size, disc.conductivity_ratio);
    if (ratios) at[dimension - 1] = disc.conductivity_ratio;
    return at;
  };
  PosteriorSamples out;
  problem.residuals = [&](const VectorXd& at) -> VectorXd {
    const Scene scene = scene_of(draw_of(at));
    ++out.solves;
    const VectorXd row = likelihood.voltages_of({&scene, 1}).row(0);
    return (row - likelihood.frame()) / likelihood.channel_noise(row);
  };
  std::vector<SceneFit> fits;
  problem.log_target = [&](std::span<const VectorXd> places) {
    std::vector<Scene> scenes;
    std::vector<double> logs;
    std::vector<std::size_t> possible;
    fits.assign(places.size(), {});
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SceneDraw draw = draw_of(places[i]);
      logs.push_back(prior.log_density(draw));
      // The derivative of the size by the logarithm of the strength.
      if (strengths) logs.back() += std::log(draw.front().size / 2);
      if (!std::isfinite(logs.back())) continue;
      possible.push_back(i);
      scenes.push_back(scene_of(draw));
    }
    const std::vector<SceneFit> found = likelihood.of(scenes);
    out.solves += scenes.size();
    for (std::size_t i = 0; i < possible.size(); ++i) {
      fits[possible[i]] = found[i];
      logs[possible[i]] += found[i].log_likelihood;
    }
    return logs;
  };
  std::vector<std::size_t> order(bank.size());
  std::iota(order.begin(), order.end(), 0);
  const std::size_t kept = std::min<std::size_t>(importance_starts, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return bank_fits[a].log_likelihood > bank_fits[b].log_likelihood;
                    });
  std::vector<VectorXd> starts;
  for (std::size_t i = 0; i < kept; ++i) starts.push_back(numbers_of(bank[order[i]].front()));
  const WeightedPoints found = sample_by_importance(problem, starts, points, random);
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    const double weight = found.weights[static_cast<Index>(i)];
    if (weight > 0) out.samples.push_back({draw_of(found.points[i]), fits[i], weight, 0});
  }
  out.pareto_k = found.pareto_k;
  return out;
}

bool is_enumerable(const ScenePrior& prior, const SceneVoltages& voltages) {
  return is_one_disc(prior) && !prior.size_is_free() && !prior.ratio_is_free() &&
         !voltages.is_smooth();
}

EnumeratedDiscs::EnumeratedDiscs(const ScenePrior& prior, const Sensor& sensor,
                                 const SceneVoltages& voltages, int side, int lattice,
                                 int threads) {
  const SceneDistribution& d = prior.distribution();
  disc_.size = d.radius.first;
  disc_.conductivity_ratio = d.conductivity_ratio.first;
  const PixelGrid pixels = sensor.sheet->pixels(side);
  const Eigen::Vector2d step = pixels.pixel() / lattice;
  const double margin = d.inside ? disc_.size : 0;
  Eigen::VectorXd ratio(pixels.count());
  std::string key(static_cast<std::size_t>(pixels.count()), ' ');
  std::unordered_map<std::string, std::size_t> known;
  std::vector<Scene> scenes;
  // Centres of the lattice's cells, so that no place lies on a border between two images.
  for (int row = 0; row < side * lattice; ++row) {
    for (int column = 0; column < side * lattice; ++column) {
      const Eigen::Vector2d place =
          pixels.corner(0, 0) + step.cwiseProduct(Eigen::Vector2d(column + 0.5, row + 0.5));
      if (sensor.sheet->depth(place) < margin) continue;
      disc_.centre = place;
      const Scene scene = scene_of({disc_});
      rasterise(scene, pixels, Rasterisation::centre, ratio);
      for (Eigen::Index p = 0; p < ratio.size(); ++p) {
        key[static_cast<std::size_t>(p)] = ratio[p] == 1 ? '0' : '1';
      }
      const auto [at, is_new] = known.emplace(key, places_.size());
      if (is_new) {
        places_.emplace_back();
        scenes.push_back(scene);
      }
      places_[at->second].push_back(place);
    }
  }
  voltages_ = voltages.solve_all(scenes, threads);
}

PosteriorSamples EnumeratedDiscs::posterior(const FrameLikelihood& likelihood) const {
  const std::vector<SceneFit> fits = likelihood.of_voltages(voltages_);
  double best = -1e300;
  for (const SceneFit& fit : fits) best = std::max(best, fit.log_likelihood);
  PosteriorSamples out;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const std::vector<Eigen::Vector2d>& places = places_[i];
    const double weight =
        std::exp(fits[i].log_likelihood - best) * static_cast<double>(places.size());
    if (weight < smallest_part) continue;
    const std::size_t stride = (places.size() + most_places_of_image - 1) / most_places_of_image;
    const std::size_t taken = (places.size() + stride - 1) / stride;
    for (std::size_t p = 0; p < places.size(); p += stride) {
      ContactDraw disc = disc_;
      disc.centre = places[p];
      out.samples.push_back({{disc}, fits[i], weight / static_cast<double>(taken), 0});
    }
  }
  return out;
}

const std::vector<std::string>& names_of_samplers() {
  static const std::vector<std::string> names = {"auto", "enumeration", "importance", "annealing"};
  return names;
}

SamplerKind resolved(SamplerKind kind, const ScenePrior& prior, const SceneVoltages& voltages) {
  if (kind != SamplerKind::automatic) return kind;
  for (const SamplerKind exact : {SamplerKind::enumeration, SamplerKind::importance}) {
    if (allows(exact, prior, voltages)) return exact;
  }
  return SamplerKind::annealing;
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
                                           RandomStream& random) const {
  const FrameLikelihood likelihood(voltages_, spec_.noise, frame);
  if (kind_ == SamplerKind::enumeration) return enumerated_->posterior(likelihood);
  const std::vector<SceneFit> fits = likelihood.of_voltages(bank_.voltages);
  if (kind_ == SamplerKind::importance) {
    return sample_disc_by_importance(prior_, likelihood, bank_.scenes, fits,
                                     pilot ? pilot_points : effort * importance_points, random);
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
  // Systematic resampling by weight.
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

PosteriorSamples PosteriorSampler::sample(const Eigen::VectorXd& frame, int effort,
                                          const PosteriorSamples* before,
                                          RandomStream& random) const {
  if (!own_) return sampled(frame, effort, false, random);
  const Eigen::VectorXd explained =
      corrected(frame, before ? *before : sampled(frame, 1, true, random), random);
  return sampled(explained, effort, false, random);
}

bool reweight(const ScenePrior& from, const ScenePrior& to, PosteriorSamples& posterior) {
  if (!from.is_comparable(to) || !has_all_of(from, to)) return false;
  std::vector<PosteriorSample> weighted;
  for (PosteriorSample sample : posterior.samples) {
    const double log = to.log_density(sample.scene) - from.log_density(sample.scene);
    if (!std::isfinite(log)) continue;
    sample.weight *= std::exp(log);
    weighted.push_back(std::move(sample));
  }
  if (kish(weighted) < least_left * kish(posterior.samples)) return false;
  posterior.samples = std::move(weighted);
  return true;
}

}  // namespace ertbench
