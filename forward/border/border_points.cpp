#include "forward/border/border_points.h"

#include <cmath>

namespace ertbench {

Graded graded_parameter(const ContactArc& arc, int index, int count) {
  const double span = arc.end - arc.begin;
  if (arc.closed) return {arc.begin + span * index / count, span};
  const double s = (index + 0.5) / count;
  // The first point stays 1e-12 of the arc away from its end, so that rounding does not matter.
  const double p = std::max(3.0, std::min(arc.grading, 27.6 / std::log(2.0 * count)));
  const bool is_cubic = p == 3;  // as on nearly all arcs; pow takes its time
  const double up = is_cubic ? s * s * s : std::pow(s, p);
  const double down = is_cubic ? (1 - s) * (1 - s) * (1 - s) : std::pow(1 - s, p);
  const double sum = up + down;
  const double slope = p * (up / s) * (down / (1 - s)) / (sum * sum);
  return {arc.begin + span * up / sum, span * slope};
}

BorderPoints border_points(const Sheet& sheet, const std::vector<ContactArc>& arcs,
                           const std::vector<int>& counts) {
  BorderPoints points;
  points.first.assign(1, 0);
  for (const int count : counts) points.first.push_back(points.first.back() + count);
  const Eigen::Index total = points.first.back();
  for (Eigen::ArrayXd* array : {&points.x, &points.y, &points.normal_x, &points.normal_y,
                                &points.curvature, &points.weight, &points.depth}) {
    array->resize(total);
  }
  points.arc.resize(static_cast<std::size_t>(total));
  for (std::size_t a = 0; a < arcs.size(); ++a) {
    for (int k = 0; k < counts[a]; ++k) {
      const Graded graded = graded_parameter(arcs[a], k, counts[a]);
      const BorderPoint border = arcs[a].piece.at(graded.parameter);
      const DiscPoint value = sheet.to_disc(border.z);
      const std::complex<double> tangent = value.first * border.first;
      const std::complex<double> bend =
          value.second * border.first * border.first + value.first * border.second;
      const double speed = std::abs(tangent);
      const Eigen::Index i = points.first[a] + k;
      points.x[i] = value.w.real();
      points.y[i] = value.w.imag();
      points.normal_x[i] = tangent.imag() / speed;
      points.normal_y[i] = -tangent.real() / speed;
      points.curvature[i] = (std::conj(tangent) * bend).imag() / (speed * speed * speed);
      points.weight[i] = speed * graded.speed / counts[a];
      points.depth[i] = 1 - std::norm(value.w);
      points.arc[static_cast<std::size_t>(i)] = static_cast<int>(a);
    }
  }
  return points;
}

}  // namespace ertbench
