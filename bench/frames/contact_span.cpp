#include "bench/frames/contact_span.h"

#include "forward/border/border_model.h"
#include "solvers/dense_svd.h"

namespace ertbench {
namespace {

constexpr int discs_across = 11;
constexpr double disc_radius = 0.08;  ///< of half the sheet's longest side
constexpr double disc_ratio = 0.5;
constexpr double resolution = 0.7;
constexpr double least_value = 0.01;  ///< of the largest singular value

}  // namespace

ContactSpan::ContactSpan(const Sensor& sensor) {
  const BorderModel model(sensor);
  const Eigen::AlignedBox2d& bounds = sensor.sheet->bounds();
  const double radius = disc_radius * bounds.sizes().maxCoeff() / 2;
  const PixelGrid places(bounds, discs_across, discs_across);
  std::vector<Eigen::VectorXd> changes;
  for (int p = 0; p < places.count(); ++p) {
    const Eigen::Vector2d centre = places.centre(p);
    if (sensor.sheet->depth(centre) < 1.2 * radius) continue;
    Contact disc;
    disc.centre = centre;
    disc.half_size = {radius, radius};
    disc.conductivity_ratio = disc_ratio;
    changes.push_back(model.solve_at({{disc}}, resolution).change);
  }
  Eigen::MatrixXd columns(sensor.channels(), static_cast<Eigen::Index>(changes.size()));
  for (std::size_t i = 0; i < changes.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = changes[i];
  }
  const DenseSvd svd = dense_svd(columns);
  const Eigen::VectorXd& values = svd.values;
  Eigen::Index kept = 0;
  while (kept < values.size() && values[kept] > least_value * values[0]) ++kept;
  basis_ = svd.left.leftCols(kept);
}

double ContactSpan::share(const Frames& changes) const {
  const double all = changes.squaredNorm();
  return all > 0 ? (changes * basis_).squaredNorm() / all : 0;
}

}  // namespace ertbench
