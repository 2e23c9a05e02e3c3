#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/errors.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/border/border_system.h"
#include "forward/border/differentiation.h"
#include "forward/border/elliptic_contact.h"

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;

/// What moves a border: the shift of its normal, times the length of border that a point stands
/// for, by unit changes of all of ContactMotion but the ratio.
Eigen::Array<double, ContactMotion::log_ratio, 1> motion(const Complex& from_centroid,
                                                         const Complex& tangent) {
  const Complex normal(tangent.imag(), -tangent.real());  // to the right, times the length
  const auto along = [&](Complex shift) { return (std::conj(normal) * shift).real(); };
  const Complex i(0, 1);
  return {along(1),
          along(i),
          along(from_centroid),
          along(i * from_centroid),
          along(std::conj(from_centroid)),
          along(i * std::conj(from_centroid))};
}

}  // namespace

BorderModel::Linearisation BorderModel::linearise(const Scene& scene, double resolution) const {
  Linearisation out;
  out.change = Eigen::VectorXd::Zero(sensor_.channels());
  out.derivatives = RowMajorMatrix::Zero(
      sensor_.channels(), ContactMotion::count * static_cast<Index>(scene.contacts.size()));
  const Eigen::VectorXd ratios = electrode_ratios(scene);
  for (Index e = 0; e < ratios.size(); ++e) {
    if (ratios[e] != 1) {
      throw InputError("electrode " +
                       std::to_string(nodes_.electrodes[static_cast<std::size_t>(e)]) +
                       ": derivatives are for scenes in which no contact covers an electrode");
    }
  }
  // A smooth border that is cut where it comes close to something would lose its slope there.
  const BorderLayout layout = border_layout(*sensor_.sheet, nodes_.places, scene, BorderCuts::none);
  for (const ContactArc& arc : layout.arcs) {
    if (!arc.closed) {
      throw InputError("contact " + std::to_string(arc.contact) +
                       ": derivatives are for discs and ellipses that lie whole inside the sheet "
                       "and cross no other contact");
    }
  }
  if (layout.arcs.empty()) return out;
  const BorderSystem system =
      border_system(*sensor_.sheet, layout, nodes_, ArrayXd::Ones(nodes_.nodes()), resolution);
  const BorderPoints& points = system.points;
  out.points = static_cast<int>(points.size());
  const auto factor = system.matrix.partialPivLu();
  MatrixXd density = factor.solve(system.slopes.transpose());  // [points, pairs]
  const MatrixXd nothing = MatrixXd::Zero(nodes_.nodes(), nodes_.nodes());
  const MatrixXd impedance = impedance_change(system, nothing, density);
  out.change = reciprocal_mean(impedance, system.magnitude).change;
  // The transposed equation is that of the potential: u = y / (r - l), y times weight its solution.
  MatrixXd potentials;  // [pairs, points]
  if (nodes_.is_complete()) {
    // The scene's own currents of the nodes.
    const MatrixXd shared =
        nodes_.differences(nodes_.currents_where(system.potentials * density).transpose());
    density = (density * shared.transpose()).eval();
    potentials = shared * system.potentials;
  } else {
    potentials = nodes_.pair_rows(system.potentials);
  }
  const MatrixXd transposed = factor.transpose().solve(potentials.transpose());
  const ArrayXd jump = system.right - system.left;
  const MatrixXd potential = (points.weight * jump).inverse().matrix().asDiagonal() * transposed;
  // Current density through the border: r d_n u on one side, l d_n u on the other.
  const MatrixXd current = (system.left * system.right / jump).matrix().asDiagonal() * density;

  const auto add = [&](const MatrixXd& products, Index column) {
    out.derivatives.col(column) -=
        voltages(products);  // V = -I/c0 (...), dV/dratio = +I/c0 grad u . grad u
  };
  for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
    const ContactArc& arc = layout.arcs[a];
    const Index first = points.first[a];
    const Index count = points.first[a + 1] - first;
    const auto u = potential.middleRows(first, count);
    const auto q = current.middleRows(first, count);
    const int steps = static_cast<int>(count);
    MatrixXd along = closed_differentiation(steps) * u;  // d_t u on the sheet
    MatrixXd across = q;                                 // the current there
    Eigen::Array<double, ContactMotion::log_ratio, Eigen::Dynamic> moved(
        static_cast<int>(ContactMotion::log_ratio), count);
    const Eigen::Vector2d centre = scene.contacts[static_cast<std::size_t>(arc.contact)].centroid();
    for (Index i = 0; i < count; ++i) {
      const Graded graded = graded_parameter(arc, static_cast<int>(i), static_cast<int>(count));
      const BorderPoint border = arc.piece.at(graded.parameter);
      const Complex step = border.first * graded.speed;  // dz/ds
      along.row(i) /= std::abs(step);
      across.row(i) *= points.weight[first + i] * static_cast<double>(count) / std::abs(step);
      moved.col(i) =
          motion(border.z - Complex(centre.x(), centre.y()), step / static_cast<double>(count));
    }
    // Where the border moves to the right, the left side gains (l - r) (d_t u d_t u + q q / (l r)).
    for (Index parameter = 0; parameter < ContactMotion::log_ratio; ++parameter) {
      const Eigen::VectorXd gain = (arc.left - arc.right) * moved.row(parameter).transpose();
      add(along.transpose() * gain.asDiagonal() * along +
              across.transpose() * (gain / (arc.left * arc.right)).asDiagonal() * across,
          arc.contact * ContactMotion::count + parameter);
    }
    // int grad u . grad u over the region on either side, by its border.
    const MatrixXd flux =
        u.transpose() * points.weight.segment(first, count).matrix().asDiagonal() * q;
    if (arc.left_contact >= 0) {
      add(flux, arc.left_contact * ContactMotion::count + ContactMotion::log_ratio);
    }
    if (arc.right_contact >= 0) {
      add(-flux, arc.right_contact * ContactMotion::count + ContactMotion::log_ratio);
    }
  }
  for (const auto& [a, b] : pairs_) {
    const Eigen::RowVectorXd mean = (out.derivatives.row(a) + out.derivatives.row(b)) / 2;
    out.derivatives.row(a) = mean;
    out.derivatives.row(b) = mean;
  }
  return out;
}

}  // namespace ertbench
