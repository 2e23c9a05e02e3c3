#include "forward/border/border_model.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "forward/border/border_layout.h"
#include "forward/border/border_system.h"

namespace ertbench {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Factor on the number of points from one resolution to the next.
constexpr double refinement = 1.5;
/// Remaining error relative to the change of the last refinement, at third order: 1 / (1.5^3 - 1).
constexpr double remaining = 0.42;
/// Ratio of changes at first order, 1 / 1.5; slower convergence allows no estimate.
constexpr double slowest_shrinking = 0.67;
/// Error over deviation from reciprocity: 1 in the median, at most 2 in most scenes.
constexpr double reciprocity_margin = 2;

}  // namespace

BorderModel::BorderModel(const Sensor& sensor)
    : BorderModel(sensor, VectorXd::Zero(sensor.electrode_count)) {}

BorderModel::BorderModel(const Sensor& sensor, const VectorXd& displacement,
                         const VectorXd& impedances)
    : sensor_(sensor), nodes_(sensor, displacement, impedances), pairs_(reciprocal_pairs(sensor)) {
  reference_ = voltages(nodes_.differences(nodes_.differences(nodes_.potentials).transpose()));
}

VectorXd BorderModel::voltages(const MatrixXd& impedance) const {
  VectorXd out(static_cast<Index>(nodes_.channels.size()));
  for (std::size_t c = 0; c < nodes_.channels.size(); ++c) {
    const auto& [measurement, drive] = nodes_.channels[c];
    out[static_cast<Index>(c)] = -nodes_.volts[c] * impedance(measurement, drive);
  }
  return out;
}

VectorXd BorderModel::electrode_ratios(const Scene& scene) const {
  VectorXd ratios(nodes_.nodes());
  for (Index e = 0; e < nodes_.nodes(); ++e) {
    // Just inside the sheet. If a border ends at the electrode, both sides have their share.
    const Eigen::Vector2d middle = sensor_.sheet->bounds().center();
    const std::complex<double> centre(middle.x(), middle.y());
    const std::complex<double> at =
        std::complex<double>(nodes_.positions(0, e), nodes_.positions(1, e)) - centre;
    const std::complex<double> inside = centre + (1 - 1e-9) * at;
    const std::complex<double> along = std::complex<double>(0, 1e-9) * at;
    ratios[e] = (ratio_at(scene, inside + along) + ratio_at(scene, inside - along)) / 2;
  }
  return ratios;
}

MatrixXd BorderModel::source_potentials(const ArrayXd& source,
                                        const std::vector<ScreenedRegion>& screened,
                                        const MatrixXd& potentials) const {
  MatrixXd out = nodes_.neumann * (source - 1).matrix().asDiagonal();
  for (const ScreenedRegion& region : screened) {
    MatrixXd inside = nodes_.neumann(Eigen::all, region.electrodes) - potentials * region.charges;
    VectorXd is_outside = VectorXd::Ones(source.size());
    is_outside(region.electrodes).setZero();
    const double outside = std::max(1.0, is_outside.sum());
    inside.rowwise() -= (is_outside.transpose() * inside / outside).eval();
    out(Eigen::all, region.electrodes) =
        (1 / region.ratio - 1) * (1 - is_outside.array()).matrix().asDiagonal() * inside;
  }
  return out;
}

MatrixXd BorderModel::impedance_change(const BorderSystem& system, const MatrixXd& own,
                                       const MatrixXd& density) const {
  if (!nodes_.by_nodes()) {
    MatrixXd impedance = nodes_.pair_matrix(own);
    impedance += nodes_.pair_rows(system.potentials * density);
    return impedance;
  }
  const MatrixXd by_nodes = own + system.potentials * density;
  if (!nodes_.is_complete()) return nodes_.pair_matrix(by_nodes);
  const MatrixXd currents = nodes_.currents_where(by_nodes);
  return nodes_.pair_rows(nodes_.differences((by_nodes * currents).transpose()).transpose());
}

MatrixXd BorderModel::conductors_matrix(const BorderSystem& system) const {
  if (!nodes_.is_complete()) return system.matrix;
  const MatrixXd redistributed = nodes_.redistribution * system.potentials;
  return system.matrix + system.slopes.transpose() * redistributed;
}

BorderModel::Solution BorderModel::solve_layout(const BorderLayout& layout, const ArrayXd& source,
                                                double resolution) const {
  if (layout.arcs.empty()) {
    const MatrixXd own = source_potentials(source, {}, {});
    if (!nodes_.is_complete()) return {voltages(nodes_.pair_matrix(own))};
    BorderSystem nothing;
    nothing.potentials.resize(nodes_.nodes(), 0);
    return {voltages(impedance_change(nothing, own, MatrixXd(0, nodes_.nodes())))};
  }
  const BorderSystem system = border_system(*sensor_.sheet, layout, nodes_, source, resolution);
  MatrixXd impedance;
  if (nodes_.is_complete() && (source == 1).all()) {
    const MatrixXd density =
        conductors_matrix(system).partialPivLu().solve(nodes_.pair_rows(system.slopes).transpose());
    impedance = nodes_.pair_rows(system.potentials) * density;
  } else {
    const MatrixXd own = source_potentials(source, system.screened, system.potentials);
    const MatrixXd density = system.matrix.partialPivLu().solve(system.slopes.transpose());
    impedance = impedance_change(system, own, density);
  }
  Solution solution = reciprocal_mean(impedance, system.magnitude);
  solution.points = static_cast<int>(system.points.size());
  return solution;
}

BorderModel::Solution BorderModel::reciprocal_mean(const MatrixXd& impedance,
                                                   const ArrayXd& magnitude) const {
  Solution solution{voltages(impedance)};
  ArrayXd of_electrode = ArrayXd::Zero(sensor_.electrode_count);
  for (Index n = 0; n < nodes_.nodes(); ++n) {
    double& most = of_electrode[nodes_.electrodes[static_cast<std::size_t>(n)]];
    most = std::max(most, magnitude[n]);
  }
  const auto of_pair = [&](int pair) {
    const ElectrodePair& two = nodes_.pairs[static_cast<std::size_t>(pair)];
    return std::max(of_electrode[two.first], of_electrode[two.second]);
  };
  double asymmetry = 0;
  for (const auto& [a, b] : pairs_) {
    const auto& [measurement, drive] = nodes_.channels[static_cast<std::size_t>(a)];
    const double share = 1 / (1 + std::pow(of_pair(drive) / of_pair(measurement), 2));
    // The value with drive and measurement exchanged, even if that is no channel.
    const double exchanged =
        a != b ? solution.change[b]
               : -nodes_.volts[static_cast<std::size_t>(a)] * impedance(drive, measurement);
    const double difference = solution.change[a] - exchanged;
    const double mean = exchanged + share * difference;
    asymmetry += (a != b ? 4 : 2) * share * (1 - share) * difference * difference;
    solution.change[a] = solution.change[b] = mean;
  }
  solution.error = reciprocity_margin * std::sqrt(asymmetry);
  return solution;
}

BorderModel::Solution BorderModel::solve_at(const Scene& scene, double resolution) const {
  return solve_layout(border_layout(*sensor_.sheet, nodes_.places, scene),
                      electrode_ratios(scene).array().inverse(), resolution);
}

BorderModel::Solution BorderModel::solve(const Scene& scene, double tolerance,
                                         int most_points) const {
  return solve(
      scene, [&](const VectorXd&) { return tolerance; }, most_points);
}

BorderModel::Solution BorderModel::solve(const Scene& scene, const Tolerance& tolerance,
                                         int most_points) const {
  const BorderLayout layout = border_layout(*sensor_.sheet, nodes_.places, scene);
  const ArrayXd source = electrode_ratios(scene).array().inverse();
  double resolution = 1 / refinement;
  Solution solution = solve_layout(layout, source, resolution);
  double last_step = std::numeric_limits<double>::infinity();
  while (solution.points > 0) {
    resolution *= refinement;
    Solution finer = solve_layout(layout, source, resolution);
    const double step = (finer.change - solution.change).norm();
    // Remaining error if the changes keep shrinking at this rate.
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
