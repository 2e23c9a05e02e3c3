#include "limit/annealed_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

namespace ertbench {
namespace {

/// An island whose log evidence is this far below the best one's continues from the other's scenes.
constexpr double worse = 5;
/// Below the best log evidence by this much, an island missed the mode; estimates err by some
/// units.
constexpr double missed = 15;
/// Numbers of contacts with a smaller probability are left out.
constexpr double least_probability = 1e-3;
/// Numbers of contacts with a larger probability must be found by more than one island.
constexpr double some_probability = 0.05;
/// A number of contacts whose log evidence is this far below another's is less probable than
/// least_probability, whatever the errors of the two estimates.
constexpr double hopeless = 25;

/// The scenes with one number of contacts, sampled by every island.
class Stratum {
 public:
  Stratum(const ScenePrior& prior, std::size_t contacts)
      : prior_(prior.with_contacts(contacts)),
        contacts_(contacts),
        log_probability_(prior.log_count(contacts)) {}

  /// Anneals the bank's scenes with this number of contacts, and draws more if there are too few.
  /// `least`: the log evidence below which their part of the posterior is negligible.
  void anneal(const SceneLikelihood& likelihood, const PlaceMetric& metric, JointStep* joint,
              std::span<const SceneDraw> bank, std::span<const SceneFit> bank_fits,
              const AnnealingOptions& options, double least, RandomStream& random) {
    std::vector<SceneDraw> scenes;
    std::vector<SceneFit> fits;
    for (std::size_t i = 0; i < bank.size(); ++i) {
      if (bank[i].size() != contacts_) continue;
      scenes.push_back(bank[i]);
      fits.push_back(bank_fits[i]);
    }
    const auto islands = static_cast<std::size_t>(options.islands);
    const std::size_t least_scenes = 2 * islands * static_cast<std::size_t>(options.particles);
    std::vector<Scene> drawn;
    while (scenes.size() < least_scenes) {
      scenes.push_back(prior_.draw(random));
      drawn.push_back(scene_of(scenes.back()));
    }
    for (SceneFit& fit : likelihood.of(drawn)) fits.push_back(std::move(fit));
    const std::size_t share = scenes.size() / islands;
    for (std::size_t i = 0; i < islands; ++i) {
      AnnealingIsland& island =
          islands_.emplace_back(prior_, likelihood, metric, joint, options, random);
      island.start(std::span(scenes).subspan(i * share, share),
                   std::span(fits).subspan(i * share, share));
      island.anneal(least - log_probability_);
      log_evidence_.push_back(log_probability_ + island.log_evidence());
    }
    share_out();
  }

  /// [islands] log evidence of the scenes each continues with, including the number's probability.
  const std::vector<double>& log_evidence() const { return log_evidence_; }
  double best_log_evidence() const { return *std::ranges::max_element(log_evidence_); }
  /// [islands] the island whose scenes each continues with: itself or another.
  const std::vector<std::size_t>& origins() const { return origins_; }
  /// True if one island found a mode that all others missed.
  bool alone() const { return islands_.size() > 1 && found_ == 1 && contacts_ > 0; }

  /// Appends samples whose `island` is `name`.
  void collect(std::size_t island, int name, double weight, std::vector<PosteriorSample>& samples) {
    islands_[island].collect(name, weight, samples);
  }
  std::uint64_t solves() const {
    std::uint64_t sum = 0;
    for (const AnnealingIsland& island : islands_) sum += island.solves();
    return sum;
  }

 private:
  /// Gives the scenes of good islands to worse ones, in turn. The evidence is unbiased only as a
  /// mean over all islands, including those that missed a mode, so islands that share scenes get
  /// the mean of their evidences.
  void share_out() {
    const double best = best_log_evidence();
    origins_.resize(islands_.size());
    std::iota(origins_.begin(), origins_.end(), std::size_t{0});
    if (!std::isfinite(best)) return;
    found_ = 0;
    std::vector<std::size_t> good;
    for (std::size_t i = 0; i < islands_.size(); ++i) {
      if (log_evidence_[i] > best - missed) ++found_;
      if (log_evidence_[i] > best - worse) good.push_back(i);
    }
    std::size_t next = 0;
    for (std::size_t i = 0; i < islands_.size(); ++i) {
      if (log_evidence_[i] > best - worse) continue;
      origins_[i] = good[next++ % good.size()];
      islands_[i].take(islands_[origins_[i]]);
    }
    const std::vector<double> found = log_evidence_;
    for (const std::size_t origin : good) {
      std::vector<double> shared;
      for (std::size_t i = 0; i < islands_.size(); ++i) {
        if (origins_[i] == origin) shared.push_back(found[i]);
      }
      const double mean = log_sum(shared) - std::log(static_cast<double>(shared.size()));
      for (std::size_t i = 0; i < islands_.size(); ++i) {
        if (origins_[i] == origin) log_evidence_[i] = mean;
      }
    }
  }

  ScenePrior prior_;
  std::size_t contacts_;
  double log_probability_;
  std::vector<AnnealingIsland> islands_;
  std::vector<double> log_evidence_;
  std::vector<std::size_t> origins_;
  std::size_t found_ = 0;  ///< islands that did not miss the best mode
};

/// Groups of islands that share scenes, numbered from 0.
class Groups {
 public:
  explicit Groups(std::size_t islands) : group_(islands) {
    std::iota(group_.begin(), group_.end(), 0);
  }
  void join(std::size_t a, std::size_t b) {
    const int from = std::max(group_[a], group_[b]);
    const int to = std::min(group_[a], group_[b]);
    if (from == to) return;
    for (int& group : group_) {
      if (group == from) group = to;
      if (group > from) --group;
    }
  }
  int operator[](std::size_t island) const { return group_[island]; }
  int count() const { return *std::ranges::max_element(group_) + 1; }

 private:
  std::vector<int> group_;
};

}  // namespace

PosteriorSamples sample_by_annealing(const ScenePrior& prior, const SceneLikelihood& likelihood,
                                     const PlaceMetric& metric, const EllipseModel* ellipses,
                                     std::span<const SceneDraw> bank,
                                     std::span<const SceneFit> bank_fits,
                                     const AnnealingOptions& options, RandomStream& random) {
  PosteriorSamples out;
  std::optional<JointStep> joint;
  if (ellipses) joint.emplace(prior, *ellipses);
  std::vector<std::unique_ptr<Stratum>> strata;  // their islands hold references to them
  // The largest number of contacts comes first: it explains the frame best, which allows hopeless
  // smaller numbers to be given up early.
  double best = -std::numeric_limits<double>::infinity();
  for (auto n = static_cast<std::size_t>(prior.distribution().contacts.second) + 1; n-- > 0;) {
    if (!std::isfinite(prior.log_count(n))) continue;
    strata.push_back(std::make_unique<Stratum>(prior, n));
    strata.back()->anneal(likelihood, metric, joint ? &*joint : nullptr, bank, bank_fits, options,
                          best - hopeless, random);
    best = std::max(best, strata.back()->best_log_evidence());
  }
  // Probability of each number of contacts, averaged over the islands.
  const auto islands = static_cast<std::size_t>(options.islands);
  std::vector<double> probability(strata.size(), 0);
  for (std::size_t i = 0; i < islands; ++i) {
    std::vector<double> logs;
    for (const auto& stratum : strata) logs.push_back(stratum->log_evidence()[i]);
    out.log_evidence.push_back(log_sum(logs));
    for (std::size_t s = 0; s < strata.size(); ++s) {
      probability[s] += std::exp(logs[s] - out.log_evidence.back()) / static_cast<double>(islands);
    }
  }
  Groups groups(islands);
  for (std::size_t s = 0; s < strata.size(); ++s) {
    if (probability[s] <= some_probability) continue;
    out.alone = out.alone || strata[s]->alone();
    for (std::size_t i = 0; i < islands; ++i) groups.join(i, strata[s]->origins()[i]);
  }
  out.one_origin = islands > 1 && groups.count() == 1;
  for (std::size_t s = 0; s < strata.size(); ++s) {
    for (std::size_t i = 0; i < islands && probability[s] > least_probability; ++i) {
      const double weight = std::exp(strata[s]->log_evidence()[i] - out.log_evidence[i]);
      const int name = out.one_origin ? static_cast<int>(i) : groups[i];
      strata[s]->collect(i, name, weight, out.samples);
    }
    out.solves += strata[s]->solves();
  }
  return out;
}

SceneBank draw_bank(const ScenePrior& prior, const SceneVoltages& voltages, std::size_t scenes,
                    RandomStream& random, int threads) {
  SceneBank bank;
  std::vector<Scene> drawn;
  for (std::size_t i = 0; i < scenes; ++i) {
    bank.scenes.push_back(prior.draw(random));
    drawn.push_back(scene_of(bank.scenes.back()));
  }
  bank.voltages = voltages.solve_all(drawn, threads);
  return bank;
}

}  // namespace ertbench
