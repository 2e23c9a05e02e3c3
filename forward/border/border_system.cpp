#include "forward/border/border_system.h"

#include <algorithm>
#include <cmath>
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
  MatrixXd slopes(electrodes.cols(), count);
  system.potentials.resize(electrodes.cols(), count);
  for (Index e = 0; e < electrodes.cols(); ++e) {
    const ArrayXd dx = points.x - electrodes(0, e);
    const ArrayXd dy = points.y - electrodes(1, e);
    const ArrayXd square = dx.square() + dy.square();
    slopes.row(e) = -source[e] / pi * (points.normal_x * dx + points.normal_y * dy) / square;
    system.potentials.row(e) = -0.5 / pi * square.log() * points.weight;
  }
  system.slopes = pair_differences(slopes);
  system.matrix =
      system_matrix(points, (system.right + system.left) / (2 * (system.right - system.left)));
  return system;
}

}  // namespace ertbench
