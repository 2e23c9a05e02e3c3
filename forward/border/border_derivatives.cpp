#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/errors.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/border/border_system.h"

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

/// d/ds at the equidistant points of a closed arc, s in [0, 1], of the trigonometric polynomial
/// through them.
MatrixXd differentiation(int count) {
  MatrixXd out = MatrixXd::Zero(count, count);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      for (int k = 1; 2 * k < count; ++k) {
        out(i, j) -= 4 * pi * k / count * std::sin(2 * pi * k * (i - j) / count);
      }
    }
  }
  return out;
}

/// What moves a border: in each column the shift of its normal, times the length of border that a
/// point stands for, by unit changes of centre x and y, size and angle.
Eigen::Array<double, 4, 1> motion(const Complex& from_centroid, const Complex& tangent) {
  const Complex normal(tangent.imag(), -tangent.real());  // to the right, times the length
  const auto along = [&](Complex shift) { return (std::conj(normal) * shift).real(); };
  return {along(1), along(Complex(0, 1)), along(from_centroid),
          along(Complex(0, 1) * from_centroid)};
}

}  // namespace

RowMajorMatrix BorderModel::derivatives(const Scene& scene, double resolution) const {
  constexpr Index ratio_column = derivatives_per_contact - 1;
  RowMajorMatrix out = RowMajorMatrix::Zero(
      sensor_.channels(), derivatives_per_contact * static_cast<Index>(scene.contacts.size()));
  const BorderLayout layout = border_layout(*sensor_.sheet, electrodes_, scene, BorderCuts::none);
  for (const ContactArc& arc : layout.arcs) {
    if (!arc.closed) {
      throw InputError("contact " + std::to_string(arc.contact) +
                       ": derivatives are for discs and ellipses that lie whole inside the sheet "
                       "and cross no other contact");
    }
  }
  if (layout.arcs.empty()) return out;

  const BorderSystem system = border_system(*sensor_.sheet, layout, electrodes_,
                                            ArrayXd::Ones(electrodes_.cols()), resolution);
  const BorderPoints& points = system.points;
  const auto factor = system.matrix.partialPivLu();
  const MatrixXd density = factor.solve(system.slopes.transpose());  // [points, drives]
  // The transposed equation is that of the potential: u = y / (r - l), y times weight its solution.
  const MatrixXd solution =
      factor.transpose().solve(pair_differences(system.potentials).transpose());
  const ArrayXd jump = system.right - system.left;
  const MatrixXd potential = (points.weight * jump).inverse().matrix().asDiagonal() * solution;
  // Current density through the border: r d_n u on one side, l d_n u on the other.
  const MatrixXd current = (system.left * system.right / jump).matrix().asDiagonal() * density;

  const auto add = [&](const MatrixXd& products, Index column) {
    out.col(column) -= voltages(products);  // V = -I/c0 (...), dV/dratio = +I/c0 grad u . grad u
  };
  for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
    const ContactArc& arc = layout.arcs[a];
    const Index first = points.first[a];
    const Index count = points.first[a + 1] - first;
    const auto u = potential.middleRows(first, count);
    const auto q = current.middleRows(first, count);
    MatrixXd along = differentiation(static_cast<int>(count)) * u;  // d_t u on the sheet
    MatrixXd across = q;                                            // the current there
    Eigen::Array4Xd moved(4, count);
    const Eigen::Vector2d centre = scene.contacts[static_cast<std::size_t>(arc.contact)].centre;
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
    for (Index parameter = 0; parameter < ratio_column; ++parameter) {
      const Eigen::VectorXd gain = (arc.left - arc.right) * moved.row(parameter).transpose();
      add(along.transpose() * gain.asDiagonal() * along +
              across.transpose() * (gain / (arc.left * arc.right)).asDiagonal() * across,
          arc.contact * derivatives_per_contact + parameter);
    }
    // int grad u . grad u over the region on either side, by its border.
    const MatrixXd flux =
        u.transpose() * points.weight.segment(first, count).matrix().asDiagonal() * q;
    if (arc.left_contact >= 0) {
      add(flux / arc.left, arc.left_contact * derivatives_per_contact + ratio_column);
    }
    if (arc.right_contact >= 0) {
      add(-flux / arc.right, arc.right_contact * derivatives_per_contact + ratio_column);
    }
  }
  for (const auto& [a, b] : pairs_) {
    const Eigen::RowVectorXd mean = (out.row(a) + out.row(b)) / 2;
    out.row(a) = mean;
    out.row(b) = mean;
  }
  return out;
}

}  // namespace ertbench
