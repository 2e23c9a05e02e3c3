#include "bench/limit/place_metric.h"

#include <algorithm>
#include <cmath>

#include "forward/border/border_model.h"
#include "forward/ellipses/nearest_ellipse.h"

namespace ertbench {
namespace {

constexpr int metric_side = 24;  ///< places along one side
constexpr double probe_radius = 0.02;

}  // namespace

double area_of(const ContactDraw& contact) { return nearest_ellipse(contact_of(contact)).area(); }

double strength_of(const ContactDraw& contact) {
  const double f = contact.conductivity_ratio;
  return area_of(contact) * 2 * (1 - f) / (1 + f);
}

PlaceMetric::PlaceMetric(const Eigen::Matrix3d& precision)
    : box_(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)), precision_{precision} {}

PlaceMetric::PlaceMetric(const Sensor& sensor, double channel_noise)
    : box_(sensor.sheet->bounds()) {
  const BorderModel model(sensor);
  const PixelGrid places = sensor.sheet->pixels(metric_side);
  columns_ = places.columns();
  rows_ = places.rows();
  ContactDraw probe;
  probe.size = probe_radius;
  probe.conductivity_ratio = 0.5;
  const double strength = strength_of(probe);
  const auto change_at = [&](const Eigen::Vector2d& centre) -> Eigen::VectorXd {
    probe.centre = centre;
    // At a corner of the bounds there may be no sheet.
    if (sensor.sheet->depth(centre) < probe_radius) {
      return Eigen::VectorXd::Zero(sensor.channels());
    }
    return model.solve_at(scene_of({probe}), 1).change / (strength * channel_noise);
  };
  const double step = places.pixel().x() / 4;
  for (int p = 0; p < places.count(); ++p) {
    const Eigen::Vector2d centre = places.centre(p);
    const auto slope = [&](const Eigen::Vector2d& by) -> Eigen::VectorXd {
      return (change_at(centre + by) - change_at(centre - by)) / (2 * step);
    };
    Eigen::MatrixX3d jacobian(sensor.channels(), 3);
    jacobian.col(0) = slope({step, 0});
    jacobian.col(1) = slope({0, step});
    jacobian.col(2) = change_at(centre);
    precision_.emplace_back(jacobian.transpose() * jacobian);
  }
}

Eigen::Matrix3d PlaceMetric::information(const ContactDraw& contact) const {
  const Eigen::Vector2d place = (contact.centre - box_.min()).cwiseQuotient(box_.sizes());
  const int column = std::clamp(static_cast<int>(place.x() * columns_), 0, columns_ - 1);
  const int row = std::clamp(static_cast<int>(place.y() * rows_), 0, rows_ - 1);
  const double strength = strength_of(contact);
  // The strength grows with the square of the size.
  const Eigen::Vector3d scale(strength, strength, 2 * strength);
  return scale.asDiagonal() * precision_[static_cast<std::size_t>(row * columns_ + column)] *
         scale.asDiagonal();
}

}  // namespace ertbench
