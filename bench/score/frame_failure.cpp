#include "bench/score/frame_failure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "bench/score/metrics.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;

/// Share of the background; smaller changes count as the untouched sheet.
constexpr double untouched = 1e-9;

double distance_to_segment(const Vector2d& point, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0 ? std::clamp((point - a).dot(along) / length, 0.0, 1.0) : 0;
  return (point - a - share * along).norm();
}

/// Corners of the border of a contact that is no disc.
std::vector<Vector2d> corners(const Contact& contact) {
  if (contact.shape == Shape::polygon) return contact.vertices;
  const int count = contact.shape == Shape::rectangle ? 4 : 180;
  // A rectangle's corners lie on the ellipse through them.
  const double stretch = contact.shape == Shape::rectangle ? std::numbers::sqrt2 : 1;
  const double first = contact.shape == Shape::rectangle ? std::numbers::pi / 4 : 0;
  const Eigen::Rotation2Dd turn(contact.angle);
  std::vector<Vector2d> out;
  for (int i = 0; i < count; ++i) {
    const double t = first + 2 * std::numbers::pi * i / count;
    const Vector2d unit(std::cos(t), std::sin(t));
    out.emplace_back(contact.centre + turn * (stretch * unit.cwiseProduct(contact.half_size)));
  }
  return out;
}

/// Centroid of the strongest contact in the image.
Vector2d strongest(const Sensor& sensor, const RowVectorXd& size) {
  const PixelGrid pixels = sensor.image();
  const int columns = pixels.columns();
  Eigen::Index peak = 0;
  const double limit = 0.5 * (1 - untouched) * size.maxCoeff(&peak);
  std::vector<int> stack = {static_cast<int>(peak)};
  std::vector<bool> seen(static_cast<std::size_t>(size.size()), false);
  seen[static_cast<std::size_t>(peak)] = true;
  Vector2d sum = Vector2d::Zero();
  int count = 0;
  while (!stack.empty()) {
    const int pixel = stack.back();
    stack.pop_back();
    const int column = pixel % columns;
    const int row = pixel / columns;
    sum += pixels.centre(pixel);
    ++count;
    const auto visit = [&](int next) {
      if (seen[static_cast<std::size_t>(next)] || size[next] < limit) return;
      seen[static_cast<std::size_t>(next)] = true;
      stack.push_back(next);
    };
    if (column > 0) visit(pixel - 1);
    if (column + 1 < columns) visit(pixel + 1);
    if (row > 0) visit(pixel - columns);
    if (row + 1 < pixels.rows()) visit(pixel + columns);
  }
  return sum / count;
}

}  // namespace

double distance_to(const Contact& contact, const Vector2d& point) {
  if (contact.contains(point)) return 0;
  if (contact.shape == Shape::disc) {
    return std::max(0.0, (point - contact.centre).norm() - contact.half_size.x());
  }
  const std::vector<Vector2d> border = corners(contact);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < border.size(); ++i) {
    const Vector2d& next = border[(i + 1) % border.size()];
    least = std::min(least, distance_to_segment(point, border[i], next));
  }
  return least;
}

JudgedFrame judge(const Sensor& sensor, const FailureRule& rule, const Scene& scene,
                  const Eigen::Ref<const RowVectorXd>& conductivity,
                  const Eigen::Ref<const RowVectorXd>& change, FrameStatus status) {
  JudgedFrame frame;
  frame.status = status;
  const auto fail = [&](FailureKind kind, bool failed) {
    if (failed) frame.failed |= static_cast<int>(kind);
  };
  if (status == FrameStatus::undefined || !change.allFinite()) {
    fail(FailureKind::undefined, true);
    return frame;
  }
  const RowVectorXd size = change.cwiseAbs() / sensor.background;
  frame.peak = size.maxCoeff();
  const double strength = (conductivity.array() / sensor.background - 1).abs().maxCoeff();
  if (strength <= untouched) {
    fail(FailureKind::false_positive, *frame.peak >= rule.contact_threshold);
    return frame;
  }
  frame.error = frame_metric(Metric::relative_error, sensor, conductivity, change, scene);
  fail(FailureKind::worse_than_nothing, !frame.error || *frame.error >= rule.relative_error);
  if (*frame.peak <= untouched) return frame;
  const Vector2d place = strongest(sensor, size);
  double least = std::numeric_limits<double>::infinity();
  for (const Contact& contact : scene.contacts) {
    least = std::min(least, distance_to(contact, place));
  }
  frame.distance = least;
  fail(FailureKind::misplaced, least > rule.distance);
  return frame;
}

}  // namespace ertbench
