#include "bench/limit/disc_importance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int importance_starts = 24;

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
                                           RandomStream& random, WeightedPoints* quality) {
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
  // What voltages tell of size and conductivity is the strength; it takes the place of the size, so
  // that the posterior is no crescent.
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
      if (strengths) logs.back() += std::log(draw.front().size / 2);  // of the size by its place
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
  if (quality) *quality = found;
  return out;
}

}  // namespace ertbench
