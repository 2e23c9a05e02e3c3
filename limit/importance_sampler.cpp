#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

#include "limit/posterior_sampler.h"
#include "limit/scene_likelihood.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double degrees_of_freedom = 5;  ///< of the Student distributions
constexpr double student_width = 1.2;     ///< relative to the Laplace approximation
constexpr double uniform_share = 0.1;
constexpr int adapting_rounds = 3;

/// A mode of the posterior, with the Cholesky factor of its information matrix.
struct Mode {
  VectorXd place;
  Eigen::LLT<MatrixXd> information;
  double cost = 0;  ///< half the sum of the squared residuals
};

class Optimiser {
 public:
  explicit Optimiser(const LaplaceProblem& problem) : problem_(problem) {}

  /// Levenberg-Marquardt iteration, confined to the box.
  Mode climb(VectorXd place) const {
    double damping = 1e-2;
    VectorXd residuals = problem_.residuals(place);
    double cost = residuals.squaredNorm() / 2;
    MatrixXd information;
    for (int step = 0; step < 40; ++step) {
      const MatrixXd jacobian = jacobian_at(place, residuals);
      information = jacobian.transpose() * jacobian;
      const VectorXd gradient = jacobian.transpose() * residuals;
      bool better = false;
      double gained = 0;
      for (int attempt = 0; attempt < 8 && !better; ++attempt) {
        MatrixXd damped = information;
        damped.diagonal() += damping * information.diagonal();
        damped.diagonal().array() += 1e-12 * information.diagonal().maxCoeff();
        const VectorXd trial =
            (place - damped.llt().solve(gradient)).cwiseMax(problem_.low).cwiseMin(problem_.high);
        const VectorXd after = problem_.residuals(trial);
        const double trial_cost = after.squaredNorm() / 2;
        better = trial_cost < cost;
        damping = better ? damping / 5 : damping * 6;
        if (!better) continue;
        gained = cost - trial_cost;
        place = trial;
        residuals = after;
        cost = trial_cost;
      }
      if (!better || gained < 1e-4) break;
    }
    // The variance of the prior's box bounds directions that the data do not determine.
    const Eigen::ArrayXd widths = problem_.high - problem_.low;
    information.diagonal().array() += 12 / widths.square();
    return {place, Eigen::LLT<MatrixXd>(information), cost};
  }

 private:
  MatrixXd jacobian_at(const VectorXd& place, const VectorXd& residuals) const {
    MatrixXd jacobian(residuals.size(), place.size());
    for (Index p = 0; p < place.size(); ++p) {
      // One-sided, towards the middle of the box.
      const double width = problem_.high[p] - problem_.low[p];
      const bool upper = place[p] > (problem_.low[p] + problem_.high[p]) / 2;
      VectorXd moved = place;
      const double step = (upper ? -1e-5 : 1e-5) * width;
      moved[p] += step;
      jacobian.col(p) = (problem_.residuals(moved) - residuals) / step;
    }
    return jacobian;
  }

  const LaplaceProblem& problem_;
};

double log_student(const Mode& mode, const VectorXd& at) {
  const auto n = static_cast<double>(at.size());
  const VectorXd step = (at - mode.place) / student_width;
  const VectorXd white = mode.information.matrixU() * step;
  return sum_of_logs(mode.information.matrixLLT().diagonal().array()) -
         n * std::log(student_width) + std::lgamma((degrees_of_freedom + n) / 2) -
         std::lgamma(degrees_of_freedom / 2) -
         n / 2 * std::log(degrees_of_freedom * std::numbers::pi) -
         (degrees_of_freedom + n) / 2 * std::log1p(white.squaredNorm() / degrees_of_freedom);
}

VectorXd draw_student(const Mode& mode, RandomStream& random) {
  VectorXd white(mode.place.size());
  for (double& value : white) value = random.normal();
  double chi = 0;
  for (int d = 0; d < static_cast<int>(degrees_of_freedom); ++d) {
    const double z = random.normal();
    chi += z * z;
  }
  const VectorXd step = mode.information.matrixU().solve(white);
  return mode.place + step * (student_width * std::sqrt(degrees_of_freedom / chi));
}

/// A Gaussian with the mean and the covariance of the weighted points.
std::optional<Mode> moments_of(const WeightedPoints& found) {
  const Index n = found.points.front().size();
  VectorXd mean = VectorXd::Zero(n);
  MatrixXd covariance = MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    const double weight = found.weights[static_cast<Index>(i)];
    mean += weight * found.points[i];
    covariance += weight * found.points[i] * found.points[i].transpose();
  }
  covariance -= mean * mean.transpose();
  // One point with most of the weight has no covariance.
  constexpr double least_points = 10;
  if (found.effective < least_points) return std::nullopt;
  const Eigen::LLT<MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const MatrixXd information = factor.solve(MatrixXd::Identity(n, n));
  return Mode{mean, Eigen::LLT<MatrixXd>(information), 0};
}

/// Points drawn from Student distributions around the modes and from the box, with their weights.
WeightedPoints weighted_points(const LaplaceProblem& problem, const std::vector<Mode>& modes,
                               std::vector<double> shares, int points, RandomStream& random) {
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share *= (1 - uniform_share) / sum;
  const double log_box = -sum_of_logs((problem.high - problem.low).array());
  WeightedPoints out;
  VectorXd log_proposal(points);
  for (int i = 0; i < points; ++i) {
    double left = random.uniform() - uniform_share;
    VectorXd point(problem.low.size());
    if (left < 0) {
      for (Index p = 0; p < point.size(); ++p) {
        point[p] = random.uniform(problem.low[p], problem.high[p]);
      }
    } else {
      std::size_t m = 0;
      while (m + 1 < modes.size() && left >= shares[m]) left -= shares[m++];
      point = draw_student(modes[m], random);
    }
    const bool in_box = (point.array() >= problem.low.array()).all() &&
                        (point.array() <= problem.high.array()).all();
    double density = in_box ? uniform_share * std::exp(log_box) : 0;
    for (std::size_t m = 0; m < modes.size(); ++m) {
      density += shares[m] * std::exp(log_student(modes[m], point));
    }
    log_proposal[i] = std::log(density);
    out.points.push_back(std::move(point));
  }
  const std::vector<double> log_target = problem.log_target(out.points);
  out.weights.resize(points);
  for (int i = 0; i < points; ++i) {
    // Both densities may be zero outside the prior.
    const double log = log_target[static_cast<std::size_t>(i)];
    out.weights[i] = std::isfinite(log) ? log - log_proposal[i] : -1e300;
  }
  out.weights = exp_of(out.weights.array() - out.weights.maxCoeff());
  out.pareto_k = pareto_smoothed(out.weights);
  out.weights /= out.weights.sum();
  out.effective = 1 / out.weights.squaredNorm();
  return out;
}

/// Removes duplicates and modes with negligible weight; the best comes first.
std::vector<Mode> distinct(std::vector<Mode> modes) {
  constexpr double hopeless = 20;  ///< cost above that of the best mode
  std::ranges::sort(modes, [](const Mode& a, const Mode& b) { return a.cost < b.cost; });
  std::vector<Mode> out;
  for (Mode& mode : modes) {
    if (!std::isfinite(mode.cost) || mode.cost > modes.front().cost + hopeless) continue;
    const bool known = std::ranges::any_of(out, [&](const Mode& other) {
      const VectorXd white = other.information.matrixU() * (mode.place - other.place);
      return white.norm() < 1;
    });
    if (!known) out.push_back(std::move(mode));
  }
  return out;
}

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
  const double largest = *std::ranges::max_element(log_profile);
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

WeightedPoints sample_by_importance(const LaplaceProblem& problem, std::span<const VectorXd> starts,
                                    int points, RandomStream& random) {
  const Optimiser optimiser(problem);
  std::vector<Mode> found;
  for (const VectorXd& start : starts) found.push_back(optimiser.climb(start));
  std::vector<Mode> modes = distinct(std::move(found));
  const std::size_t count = modes.size();
  std::vector<double> shares;
  for (const Mode& mode : modes) shares.push_back(std::exp((modes.front().cost - mode.cost) / 2));
  // Short rounds adapt the proposal where the posterior is wider than its curvature suggests.
  for (int round = 0; round < adapting_rounds; ++round) {
    const WeightedPoints pilot = weighted_points(problem, modes, shares, points / 4, random);
    std::optional<Mode> wider = moments_of(pilot);
    if (!wider) continue;
    modes.resize(count);
    shares.resize(count);
    modes.push_back(std::move(*wider));
    shares.push_back(std::accumulate(shares.begin(), shares.end(), 0.0));
  }
  WeightedPoints out = weighted_points(problem, modes, shares, points, random);
  out.modes = count;
  return out;
}

double pareto_smoothed(Eigen::VectorXd& weights) {
  const auto count = static_cast<std::size_t>(weights.size());
  if (count < 25) return 0;
  std::vector<Eigen::Index> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](Eigen::Index a, Eigen::Index b) { return weights[a] < weights[b]; });
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
