#include "forward/border/border_model.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "forward/border/border_layout.h"
#include "forward/border/border_system.h"

namespace ertbench {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Points from one resolution of the ladder to the next.
constexpr double refinement = 1.5;
/// Of what the last refinement changed, what is still missing at third order: 1 / (1.5^3 - 1).
constexpr double remaining = 0.42;
/// First order's 1 / 1.5: of steps that shrink more slowly nothing can be told.
constexpr double slowest_shrinking = 0.67;
/// The error over the distance from reciprocity: 1 in the median, at most 2 in most scenes.
constexpr double reciprocity_margin = 2;

}  // namespace

BorderModel::BorderModel(const Sensor& sensor)
    : BorderModel(sensor, VectorXd::Zero(sensor.electrode_count)) {}

BorderModel::BorderModel(const Sensor& sensor, const VectorXd& displacement)
    : sensor_(sensor),
      positions_(electrode_positions(sensor, displacement)),
      electrodes_(2, sensor.electrode_count),
      neumann_(MatrixXd::Zero(sensor.electrode_count, sensor.electrode_count)),
      channels_(channels_of(sensor)),
      pairs_(reciprocal_pairs(sensor)) {
  for (Index e = 0; e < positions_.cols(); ++e) {
    const std::complex<double> w = sensor.sheet->to_disc({positions_(0, e), positions_(1, e)}).w;
    electrodes_.col(e) << w.real() / std::abs(w), w.imag() / std::abs(w);
    for (Index f = 0; f < e; ++f) {
      const double distance = (electrodes_.col(e) - electrodes_.col(f)).matrix().norm();
      neumann_(e, f) = neumann_(f, e) = -std::log(distance) / std::numbers::pi;
    }
  }
  reference_ = voltages(pair_differences(pair_differences(neumann_).transpose()));
}

VectorXd BorderModel::voltages(const MatrixXd& impedance) const {
  VectorXd out(sensor_.channels());
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    out[static_cast<Index>(c)] = -sensor_.drive_current / sensor_.background *
                                 impedance(channels_[c].measurement, channels_[c].drive);
  }
  return out;
}

VectorXd BorderModel::electrode_ratios(const Scene& scene) const {
  VectorXd ratios(positions_.cols());
  for (Index e = 0; e < positions_.cols(); ++e) {
    // Just inside the sheet; where a border ends at the electrode, each side has its share.
    const Eigen::Vector2d middle = sensor_.sheet->bounds().center();
    const std::complex<double> centre(middle.x(), middle.y());
    const std::complex<double> at =
        std::complex<double>(positions_(0, e), positions_(1, e)) - centre;
    const std::complex<double> inside = centre + (1 - 1e-9) * at;
    const std::complex<double> along = std::complex<double>(0, 1e-9) * at;
    ratios[e] = (ratio_at(scene, inside + along) + ratio_at(scene, inside - along)) / 2;
  }
  return ratios;
}

MatrixXd BorderModel::source_potentials(const ArrayXd& source,
                                        const std::vector<ScreenedRegion>& screened,
                                        const MatrixXd& potentials) const {
  MatrixXd out = neumann_ * (source - 1).matrix().asDiagonal();
  for (const ScreenedRegion& region : screened) {
    MatrixXd inside = neumann_(Eigen::all, region.electrodes) - potentials * region.charges;
    VectorXd is_outside = VectorXd::Ones(source.size());
    is_outside(region.electrodes).setZero();
    const double outside = std::max(1.0, is_outside.sum());
    inside.rowwise() -= (is_outside.transpose() * inside / outside).eval();
    out(Eigen::all, region.electrodes) =
        (1 / region.ratio - 1) * (1 - is_outside.array()).matrix().asDiagonal() * inside;
  }
  return out;
}

BorderModel::Solution BorderModel::solve_layout(const BorderLayout& layout, const ArrayXd& source,
                                                double resolution) const {
  if (layout.arcs.empty()) {
    const MatrixXd own = source_potentials(source, {}, {});
    return {voltages(pair_differences(pair_differences(own.transpose()).transpose()))};
  }
  const BorderSystem system =
      border_system(*sensor_.sheet, layout, electrodes_, source, resolution);
  const MatrixXd own = source_potentials(source, system.screened, system.potentials);
  MatrixXd impedance = pair_differences(pair_differences(own.transpose()).transpose());
  impedance += pair_differences(system.potentials *
                                system.matrix.partialPivLu().solve(system.slopes.transpose()));
  Solution solution{voltages(impedance), static_cast<int>(system.points.size())};
  average_reciprocal(system.magnitude, solution);
  return solution;
}

void BorderModel::average_reciprocal(const ArrayXd& magnitude, Solution& solution) const {
  const Index electrodes = magnitude.size();
  const auto of_drive = [&](int channel) {
    const Index k = channels_[static_cast<std::size_t>(channel)].drive;
    return std::max(magnitude[k], magnitude[(k + 1) % electrodes]);
  };
  double asymmetry = 0;
  for (const auto& [a, b] : pairs_) {
    const double share = 1 / (1 + std::pow(of_drive(a) / of_drive(b), 2));  // of a in the mean
    const double difference = solution.change[a] - solution.change[b];
    const double mean = solution.change[b] + share * difference;
    asymmetry += 4 * share * (1 - share) * difference * difference;
    solution.change[a] = solution.change[b] = mean;
  }
  solution.error = reciprocity_margin * std::sqrt(asymmetry);
}

BorderModel::Solution BorderModel::solve_at(const Scene& scene, double resolution) const {
  return solve_layout(border_layout(*sensor_.sheet, electrodes_, scene),
                      electrode_ratios(scene).array().inverse(), resolution);
}

BorderModel::Solution BorderModel::solve(const Scene& scene, double tolerance,
                                         int most_points) const {
  return solve(
      scene, [&](const VectorXd&) { return tolerance; }, most_points);
}

BorderModel::Solution BorderModel::solve(const Scene& scene, const Tolerance& tolerance,
                                         int most_points) const {
  const BorderLayout layout = border_layout(*sensor_.sheet, electrodes_, scene);
  const ArrayXd source = electrode_ratios(scene).array().inverse();
  double resolution = 1 / refinement;
  Solution solution = solve_layout(layout, source, resolution);
  double last_step = std::numeric_limits<double>::infinity();
  while (solution.points > 0) {
    resolution *= refinement;
    Solution finer = solve_layout(layout, source, resolution);
    const double step = (finer.change - solution.change).norm();
    // What is missing if the steps go on shrinking as they did.
    const double shrinking = std::min(step / last_step, slowest_shrinking);
    finer.error = std::max(finer.error, std::max(remaining, shrinking / (1 - shrinking)) * step);
    last_step = step;
    solution = std::move(finer);
    if (solution.error <= tolerance(solution.change) || refinement * solution.points > most_points)
      break;
  }
  return solution;
}

}  // namespace ertbench
