#include "forward/border/border_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace ertbench {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

/// 1 / (2 mu) less the normal derivative of N, times the points' weights.
MatrixXd system_matrix(const BorderPoints& p, const ArrayXd& half_inverse_mu) {
  const Index count = p.size();
  MatrixXd system(count, count);
  const ArrayXd outward = p.normal_x * p.x + p.normal_y * p.y;
  for (Index j = 0; j < count; ++j) {
    const double scale = p.weight[j] / (2 * pi);
    const double x = p.x[j];
    const double y = p.y[j];
    const double depth = p.depth[j];
    double* column = system.col(j).data();
    for (Index i = 0; i < count; ++i) {
      const double dx = p.x[i] - x;
      const double dy = p.y[i] - y;
      const double square = dx * dx + dy * dy;
      const double along = p.normal_x[i] * dx + p.normal_y[i] * dy;
      // |1 - w conj(v)|^2 = |w - v|^2 + (1 - |w|^2) (1 - |v|^2)
      column[i] =
          scale * (along / square + (along - depth * outward[i]) / (square + depth * p.depth[i]));
    }
    column[j] = half_inverse_mu[j] + scale * (p.curvature[j] / 2 - outward[j] / depth);
  }
  return system;
}

/// Gives the matrix the fluxes that are known: of a charge at y as much flows through an arc as the
/// angle turns under which y and its mirror image see a point that runs along it. A flux that is
/// slightly wrong counts as a charge, and where conductivities differ much such a charge makes a
/// potential that many times larger.
void conserve_flux(const Sheet& sheet, const BorderLayout& layout, const BorderPoints& p,
                   const ArrayXd& half_inverse_mu, MatrixXd& system) {
  for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
    const ContactArc& arc = layout.arcs[a];
    if (!is_strong(arc.left / arc.right)) continue;
    const Index first = p.first[a];
    const Index count = p.first[a + 1] - first;
    const std::complex<double> begin = sheet.to_disc(arc.piece.at(arc.begin).z).w;
    const std::complex<double> end = sheet.to_disc(arc.piece.at(arc.end).z).w;
    const ArrayXd weight = p.weight.segment(first, count);
    for (Index j = 0; j < p.size(); ++j) {
      const bool is_own = j >= first && j < first + count;
      const std::complex<double> y(p.x[j], p.y[j]);
      double turn = is_own ? pi : 0;  // a point of the arc itself is passed at half a turn
      if (!arc.closed) {
        turn += std::arg((end - y) / (begin - y)) +
                std::arg((1.0 - end * std::conj(y)) / (1.0 - begin * std::conj(y)));
      }
      auto column = system.col(j).segment(first, count);
      if (is_own) column[j - first] -= half_inverse_mu[j];
      double missing = turn / (2 * pi) - (column.array() * weight).sum() / p.weight[j];
      missing -= std::round(missing);  // whole turns, which `turn` does not count
      // It is missing where the kernel is large.
      const ArrayXd size = column.array().abs();
      column.array() += missing * p.weight[j] / (size * weight).sum() * size;
      if (is_own) column[j - first] += half_inverse_mu[j];
    }
  }
}

/// The charges on a region's border that screen its electrodes, [points, electrodes]: the equation
/// on that border alone with no conductivity inside, where no current comes out.
MatrixXd screening_charges(const ScreenedRegion& region, const BorderSystem& system,
                           const ArrayXd& half_inverse_mu, const MatrixXd& slopes) {
  std::vector<int> border;
  for (const int arc : region.arcs) {
    for (int i = system.points.first[static_cast<std::size_t>(arc)];
         i < system.points.first[static_cast<std::size_t>(arc) + 1]; ++i) {
      border.push_back(i);
    }
  }
  MatrixXd matrix = system.matrix(border, border);
  for (std::size_t k = 0; k < border.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const double side = system.left[border[k]] == region.ratio ? 0.5 : -0.5;
    matrix(i, i) += side - half_inverse_mu[border[k]];
  }
  MatrixXd charges =
      MatrixXd::Zero(system.points.size(), static_cast<Index>(region.electrodes.size()));
  const MatrixXd right_side = -slopes(region.electrodes, border).transpose();
  const MatrixXd on_border = matrix.partialPivLu().solve(right_side);
  charges(border, Eigen::all) = on_border;
  return charges;
}

}  // namespace

MatrixXd pair_differences(const MatrixXd& rows) {
  MatrixXd out(rows.rows(), rows.cols());
  for (Index k = 0; k < rows.rows(); ++k) {
    out.row(k) = rows.row((k + 1) % rows.rows()) - rows.row(k);
  }
  return out;
}

BorderSystem border_system(const Sheet& sheet, const BorderLayout& layout,
                           const Eigen::Array2Xd& electrodes, const ArrayXd& source,
                           double resolution) {
  std::vector<int> counts;
  for (const int count : layout.counts) {
    counts.push_back(std::max(3, static_cast<int>(std::ceil(resolution * count - 1e-9))));
  }
  BorderSystem system;
  system.points = border_points(sheet, layout.arcs, counts);
  const BorderPoints& points = system.points;
  const Index count = points.size();
  system.left.resize(count);
  system.right.resize(count);
  for (Index i = 0; i < count; ++i) {
    const int arc = points.arc[static_cast<std::size_t>(i)];
    system.left[i] = layout.arcs[static_cast<std::size_t>(arc)].left;
    system.right[i] = layout.arcs[static_cast<std::size_t>(arc)].right;
  }
  const ArrayXd half_inverse_mu = (system.right + system.left) / (2 * (system.right - system.left));
  system.matrix = system_matrix(points, half_inverse_mu);
  conserve_flux(sheet, layout, points, half_inverse_mu, system.matrix);
  MatrixXd slopes(electrodes.cols(), count);  // of unit charges
  system.potentials.resize(electrodes.cols(), count);
  for (Index e = 0; e < electrodes.cols(); ++e) {
    const ArrayXd dx = points.x - electrodes(0, e);
    const ArrayXd dy = points.y - electrodes(1, e);
    const ArrayXd square = dx.square() + dy.square();
    slopes.row(e) = -1 / pi * (points.normal_x * dx + points.normal_y * dy) / square;
    system.potentials.row(e) = -0.5 / pi * square.log() * points.weight;
  }
  system.screened = screened_regions(sheet, layout, points, electrodes, source);
  ArrayXd charge = source;
  for (const ScreenedRegion& region : system.screened) charge(region.electrodes) = 1;
  system.magnitude = charge.max(1);
  MatrixXd drives = charge.matrix().asDiagonal() * slopes;
  for (ScreenedRegion& region : system.screened) {
    region.charges = screening_charges(region, system, half_inverse_mu, slopes);
    const ArrayXd share = (1 - region.ratio) / (system.right - system.left);
    drives(region.electrodes, Eigen::all) +=
        region.charges.transpose() * share.matrix().asDiagonal();
  }
  system.slopes = pair_differences(drives);
  return system;
}

}  // namespace ertbench
