#pragma once

#include <Eigen/Core>
#include <vector>

#include "bench/limit/scene_prior.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Area of a contact, domain units squared.
double area_of(const ContactDraw& contact);

/// What a contact changes the field by, to first order in its size: area times 2 (1 - f) / (1 + f),
/// with the sign of the missing conductivity.
double strength_of(const ContactDraw& contact);

/// How sharply voltages tell where a small contact is and how strong: what steps of a random walk
/// are sized by. An approximation that costs nothing: samplers stay exact whatever it is.
class PlaceMetric {
 public:
  /// From the voltage changes of small discs, solved once at the centre of every pixel of a coarse
  /// grid, by the border model. `channel_noise` V.
  PlaceMetric(const Sensor& sensor, double channel_noise);
  /// The same everywhere: `precision` of a contact of strength 1.
  explicit PlaceMetric(const Eigen::Matrix3d& precision);

  /// The Fisher information of (x, y, log size) of a contact, by its place and strength.
  Eigen::Matrix3d information(const ContactDraw& contact) const;

 private:
  Eigen::AlignedBox2d box_;
  int columns_ = 1;
  int rows_ = 1;
  std::vector<Eigen::Matrix3d> precision_;  ///< [rows * columns], of (x, y, strength) at strength 1
};

}  // namespace ertbench
