#pragma once

#include <cmath>
#include <memory>
#include <numbers>

#include "forward/sheet/sensor.h"

namespace ertbench::testing {

/// The unit disc as a sheet: not the square, and with a map that needs no series. Its border is
/// counted from the top, (0, 1).
class DiscSheet : public Sheet {
 public:
  DiscSheet() : DiscSheet({Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)}) {}

  std::string name() const override { return "disc"; }
  std::string extent() const override { return "x^2 + y^2 <= 1"; }
  double area() const override { return std::numbers::pi; }
  double radius() const override { return 1; }
  double inner_radius() const override { return 1; }
  double depth(const Eigen::Vector2d& point) const override { return 1 - point.norm(); }
  const std::vector<BorderPiece>& border() const override { return border_; }
  double border_length() const override { return 2 * std::numbers::pi; }
  Eigen::Vector2d border_point(double along) const override {
    return {std::sin(along), std::cos(along)};
  }
  std::string border_start() const override { return "the top"; }
  DiscPoint to_disc(std::complex<double> point) const override { return {point, 1, 0}; }
  std::vector<Eigen::Matrix2d> symmetries() const override { return square_sheet()->symmetries(); }

 protected:
  /// For tests of what asks for nothing but the bounds.
  explicit DiscSheet(const Eigen::AlignedBox2d& bounds)
      : Sheet(bounds, 50), border_{BorderPiece::ellipse({0, 0}, {1, 0}, {0, 1})} {}

 private:
  std::vector<BorderPiece> border_;
};

/// 16 electrodes at equal distances round a disc, a pair of them symmetric to each axis.
inline Sensor disc_sensor() {
  Sensor sensor;
  sensor.sheet = std::make_shared<const DiscSheet>();
  sensor.electrode_offset = sensor.electrode_spacing() / 2;
  return sensor;
}

}  // namespace ertbench::testing
