#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "bench/limit/disc_importance.h"

namespace ertbench {
namespace {

/// Shape and scale of a generalised Pareto distribution, fitted to excesses in ascending order by
/// the method of Zhang and Stephens (2009), its shape drawn a little towards .5 as PSIS does.
struct Pareto {
  double shape = 0;
  double scale = 0;

  double quantile(double share) const {
    return std::abs(shape) < 1e-12 ? -scale * std::log1p(-share)
                                   : scale * std::expm1(-shape * std::log1p(-share)) / shape;
  }
};

Pareto fitted_pareto(const std::vector<double>& excess) {
  const auto n = static_cast<double>(excess.size());
  const int grid = 30 + static_cast<int>(std::sqrt(n));
  const double quarter = excess[(excess.size() + 2) / 4 - 1];
  std::vector<double> thetas;
  std::vector<double> log_profile;
  const auto shape_at = [&](double theta) {
    double sum = 0;
    for (const double x : excess) sum += std::log1p(-theta * x);
    return sum / n;
  };
  for (int j = 1; j <= grid; ++j) {
    const double theta = 1 / excess.back() + (1 - std::sqrt(grid / (j - 0.5))) / (3 * quarter);
    const double shape = shape_at(theta);
    thetas.push_back(theta);
    log_profile.push_back(n * (std::log(-theta / shape) - shape - 1));
  }
  const double largest = *std::max_element(log_profile.begin(), log_profile.end());
  double total = 0;
  double theta = 0;
  for (std::size_t j = 0; j < thetas.size(); ++j) {
    const double weight = std::exp(log_profile[j] - largest);
    total += weight;
    theta += weight * thetas[j];
  }
  theta /= total;
  const double shape = shape_at(theta);
  constexpr double prior_excesses = 10;
  return {(shape * n + 0.5 * prior_excesses) / (n + prior_excesses), -shape / theta};
}

}  // namespace

double pareto_smoothed(Eigen::VectorXd& weights) {
  const auto count = static_cast<std::size_t>(weights.size());
  if (count < 25) return 0;
  std::vector<Eigen::Index> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return weights[a] < weights[b]; });
  const auto tail = static_cast<std::size_t>(
      std::min(0.2 * static_cast<double>(count), 3 * std::sqrt(static_cast<double>(count))));
  const double cut = weights[order[count - tail - 1]];
  std::vector<double> excess;
  for (std::size_t i = count - tail; i < count; ++i) excess.push_back(weights[order[i]] - cut);
  // Equal weights have no tail.
  if (excess.front() <= 0 || excess.back() <= 1e-12 * cut) return 0;
  const Pareto pareto = fitted_pareto(excess);
  if (!std::isfinite(pareto.shape) || !std::isfinite(pareto.scale)) return 1;
  const double most = weights[order.back()];
  for (std::size_t i = 0; i < tail; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(tail);
    weights[order[count - tail + i]] = std::min(most, cut + pareto.quantile(share));
  }
  return pareto.shape;
}

}  // namespace ertbench
