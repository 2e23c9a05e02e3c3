#include "limit/annealed_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "core/process.h"
#include "limit/scene_likelihood.h"

namespace ertbench {
namespace {

/// Of an island's log evidence, below the best one's: it goes on from the other's scenes.
constexpr double worse = 5;
/// The same: it missed what the other found. The estimates themselves err by some units.
constexpr double missed = 15;
/// A number of contacts that is less probable is left out.
constexpr double least_probability = 1e-3;
/// One that is more probable has to be found by more than one island.
constexpr double some_probability = 0.05;
/// Of a log evidence below that of another number of contacts: of no more probability than
/// least_probability, whatever the two estimates' errors.
constexpr double hopeless = 25;

/// Logarithm of the sum of exp(values).
double log_sum(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> logs(values.data(),
                                              static_cast<Eigen::Index>(values.size()));
  const double largest = logs.maxCoeff();
  return largest + std::log(exp_of(logs - largest).sum());
}

/// The scenes of one number of contacts: a sampler of each island.
class Stratum {
 public:
  Stratum(const ScenePrior& prior, std::size_t contacts)
      : prior_(prior.with_contacts(contacts)),
        contacts_(contacts),
        log_probability_(prior.log_count(contacts)) {}

  /// Anneals the bank's scenes of so many contacts, and more where these do not do. `least`: the
  /// log evidence without which they have no part in the posterior.
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

  /// [islands] with that of the number of contacts, of the scenes that each goes on with.
  const std::vector<double>& log_evidence() const { return log_evidence_; }
  double best_log_evidence() const {
    return *std::max_element(log_evidence_.begin(), log_evidence_.end());
  }
  /// [islands] whose scenes each goes on with: its own or another's.
  const std::vector<std::size_t>& origins() const { return origins_; }
  /// Whether one island found what all others missed.
  bool alone() const { return islands_.size() > 1 && found_ == 1 && contacts_ > 0; }

  /// `name` is what the samples say of where they come from.
  void collect(std::size_t island, int name, double weight, std::vector<PosteriorSample>& samples) {
    islands_[island].collect(name, weight, samples);
  }
  std::uint64_t solves() const {
    std::uint64_t sum = 0;
    for (const AnnealingIsland& island : islands_) sum += island.solves();
    return sum;
  }

 private:
  /// Islands that are worse than others go on from the scenes of these, one after the other. An
  /// island's evidence is right in the mean over all, those that missed something among them: who
  /// shares scenes shares the mean of the evidences too.
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
  std::size_t found_ = 0;  ///< islands that did not miss what others found
};

/// Islands that share scenes anywhere are one: [islands] numbers 0 ... of the groups that are left.
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
  int count() const { return *std::max_element(group_.begin(), group_.end()) + 1; }

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
  std::vector<std::unique_ptr<Stratum>> strata;  // which islands refer to
  // Most contacts first: how well these explain the frame shows soon that fewer will not.
  double best = -std::numeric_limits<double>::infinity();
  for (auto n = static_cast<std::size_t>(prior.distribution().contacts.second) + 1; n-- > 0;) {
    if (!std::isfinite(prior.log_count(n))) continue;
    strata.push_back(std::make_unique<Stratum>(prior, n));
    strata.back()->anneal(likelihood, metric, joint ? &*joint : nullptr, bank, bank_fits, options,
                          best - hopeless, random);
    best = std::max(best, strata.back()->best_log_evidence());
  }
  // Of each island the probabilities by the evidence that it found itself.
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
  bank.voltages.resize(static_cast<Eigen::Index>(scenes), voltages.reference().size());
  parallel_for(scenes, threads, [&](std::size_t begin, std::size_t end) {
    voltages.solve(std::span(drawn).subspan(begin, end - begin), nullptr,
                   bank.voltages.middleRows(static_cast<Eigen::Index>(begin),
                                            static_cast<Eigen::Index>(end - begin)));
  });
  return bank;
}

}  // namespace ertbench
