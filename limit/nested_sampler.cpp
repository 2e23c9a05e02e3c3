#include "limit/nested_sampler.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/process.h"
#include "core/statistics.h"
#include "forward/data/generate.h"
#include "forward/data/scene_model.h"
#include "limit/posterior_sampler.h"

namespace ertbench {
namespace {

constexpr double accepted_share = 0.3;  ///< of the moves, to which their widths adapt
constexpr double adaptation = 0.02;     ///< of the logarithm of a width, by one move
constexpr double quantities = 6;        ///< of a contact, about
constexpr double least_power = 1e-9;

class NestedSampler {
 public:
  NestedSampler(const ScenePrior& prior, const SceneLikelihood& likelihood,
                const PlaceMetric& metric, const NestedOptions& options, RandomStream& random)
      : prior_(prior),
        likelihood_(likelihood),
        moves_(prior, metric),
        options_(options),
        random_(random) {
    scales_.fill(1);
    std::vector<Scene> scenes;
    for (int i = 0; i < options.live; ++i) {
      const SceneDraw drawn = prior.draw(random);
      scenes.push_back(scene_of(drawn));
      live_.push_back({drawn, prior.log_density(drawn), 0});
    }
    const std::vector<SceneFit> fits = likelihood.of(scenes);
    for (std::size_t i = 0; i < live_.size(); ++i) live_[i].log = fits[i].log_likelihood;
    solves_ = live_.size();
  }

  Evidence run() {
    const auto [worst, best] = std::ranges::minmax_element(live_, {}, &Live::log);
    if (worst->log == best->log) return {best->log, 0};  // the prior has one scene
    const double count = options_.live;
    double log_left = 0;  // of the prior
    for (;;) {
      const auto [low, high] = std::ranges::minmax_element(live_, {}, &Live::log);
      if (high->log + log_left < log_evidence_ + std::log(options_.rest)) break;
      // The part that goes is the share 1 - exp(-1 / count) of what is left, in the mean.
      add(low->log, log_left + std::log(-std::expm1(-1 / count)));
      log_left -= 1 / count;
      renew(*low, high->log);
    }
    for (const Live& scene : live_) add(scene.log, log_left - std::log(count));
    return {log_evidence_, std::sqrt(std::max(0.0, mean_log_ - log_evidence_) / count)};
  }

  std::uint64_t solves() const { return solves_; }

 private:
  struct Live {
    SceneDraw scene;
    double log_prior;
    double log;  ///< likelihood
  };

  /// Adds a part of the prior to the evidence, and its log likelihood to the posterior's mean.
  void add(double log_likelihood, double log_part) {
    const double before = log_evidence_;
    log_evidence_ = log_sum({before, log_likelihood + log_part});
    mean_log_ = std::exp(before - log_evidence_) * mean_log_ +
                std::exp(log_likelihood + log_part - log_evidence_) * log_likelihood;
  }

  /// Puts a moved copy of another scene in the place of the worst.
  void renew(Live& worst, double best) {
    const double least = worst.log;
    const auto others = static_cast<int>(live_.size()) - 1;
    auto other = static_cast<std::size_t>(random_.integer(0, others - 1));
    if (&live_[other] == &worst) other = static_cast<std::size_t>(others);
    worst = live_[other];
    // The power at which a Gaussian of so many quantities is as wide as the part that is left.
    const double power =
        std::clamp(quantities * static_cast<double>(worst.scene.size()) / (2 * (best - least)),
                   least_power, 1.0);
    for (int m = 0; m < options_.moves; ++m) {
      const Move kind = moves_.choose(random_);
      double& scale = scales_[static_cast<std::size_t>(kind)];
      const bool taken = move(worst, kind, scale, power, least);
      scale =
          std::clamp(scale * std::exp(adaptation * ((taken ? 1 : 0) - accepted_share)), 1e-4, 2.0);
    }
  }

  bool move(Live& scene, Move kind, double scale, double power, double least) {
    std::optional<Proposal> proposal = moves_.propose(kind, scene.scene, scale, power, random_);
    if (!proposal) return false;
    const double log_prior = prior_.log_density(proposal->scene);
    const double chance = std::log(1 - random_.uniform());
    if (!(chance < log_prior - scene.log_prior + proposal->log_ratio)) return false;
    const Scene moved = scene_of(proposal->scene);
    const double log = likelihood_.of({&moved, 1}, {&least, 1}).front().log_likelihood;
    ++solves_;
    if (!(log > least)) return false;
    scene = {std::move(proposal->scene), log_prior, log};
    return true;
  }

  const ScenePrior& prior_;
  const SceneLikelihood& likelihood_;
  SceneMoves moves_;
  const NestedOptions& options_;
  RandomStream& random_;
  MoveScales scales_{};
  std::vector<Live> live_;
  double log_evidence_ = -std::numeric_limits<double>::infinity();
  double mean_log_ = 0;  ///< posterior mean of the log likelihood
  std::uint64_t solves_ = 0;
};

/// Shares of the numbers of contacts among samples.
std::vector<double> numbers_of(const PosteriorSamples& found, std::size_t numbers) {
  std::vector<double> shares(numbers, 0);
  double sum = 0;
  for (const PosteriorSample& sample : found.samples) sum += sample.weight;
  for (const PosteriorSample& sample : found.samples) {
    shares[sample.scene.size()] += sample.weight / sum;
  }
  return shares;
}

/// Of the mean of independent estimates, whose evidences themselves are right in the mean.
Evidence mean_of(const std::vector<double>& logs) {
  const auto count = static_cast<double>(logs.size());
  const double deviation = logs.size() > 1 ? sample_deviation(logs) / std::sqrt(count) : 0;
  return {log_sum(logs) - std::log(count), deviation};
}

}  // namespace

Evidence nested_evidence(const ScenePrior& prior, const SceneLikelihood& likelihood,
                         const PlaceMetric& metric, const NestedOptions& options,
                         RandomStream& random, std::uint64_t& solves) {
  NestedSampler sampler(prior, likelihood, metric, options, random);
  const Evidence found = sampler.run();
  solves += sampler.solves();
  return found;
}

double EvidenceCheck::deviation() const { return std::hypot(annealed.deviation, nested.deviation); }

std::vector<EvidenceCheck> check_evidences(const DatasetSpec& spec, int frames, int threads) {
  const ScenePrior prior(std::get<SceneDistribution>(spec.scenes), spec.sensor.sheet);
  const auto voltages = voltages_for(spec);
  const PosteriorSampler annealing(spec, prior, *voltages, SamplerKind::annealing, threads);
  const auto count =
      static_cast<std::size_t>(std::min(spec.count, static_cast<std::uint64_t>(frames)));
  const DatasetBlock block =
      generate_block(spec, SceneModel(spec.sensor, spec.model), 0, count, threads);
  const auto numbers = static_cast<std::size_t>(prior.distribution().contacts.second) + 1;
  std::vector<EvidenceCheck> out(count);
  Progress progress("evidences of \"" + spec.name + "\"");
  std::mutex mutex;
  std::uint64_t done = 0;
  parallel_for(count, 1, threads, [&](std::size_t i, std::size_t) {
    EvidenceCheck& check = out[i];
    const Eigen::VectorXd frame = block.voltages.row(static_cast<Eigen::Index>(i)).transpose();
    RandomStream random(key_of("nested sampling"), key_of(spec.name), i, Purpose::scene);
    const PosteriorSamples found = annealing.sample_uncorrected(frame, random);
    check.annealed = mean_of(found.log_evidence);
    check.annealed_numbers = numbers_of(found, numbers);
    const FrameLikelihood likelihood(*voltages, spec.noise, frame);
    std::vector<Evidence> parts(numbers);
    for (std::size_t n = 0; n < numbers; ++n) {
      const double log_count = prior.log_count(n);
      if (!std::isfinite(log_count)) continue;
      parts[n] = nested_evidence(prior.with_contacts(n), likelihood, annealing.metric(), {}, random,
                                 check.solves);
      parts[n].log += log_count;
      check.nested.log = log_sum({check.nested.log, parts[n].log});
    }
    for (const Evidence& part : parts) {
      check.nested_numbers.push_back(std::exp(part.log - check.nested.log));
      check.nested.deviation =
          std::hypot(check.nested.deviation, check.nested_numbers.back() * part.deviation);
    }
    const std::lock_guard lock(mutex);
    progress.update(++done, count);
  });
  return out;
}

}  // namespace ertbench
