#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// One contact as it is kept, in mm from the origin of the domain units.
struct ContactReading {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  double strength = 0;  ///< integral of |δσ| over the contact, S/m mm²
  double peak = 0;      ///< largest |δσ|, S/m
  double area_mm2 = 0;

  bool operator==(const ContactReading&) const = default;
};

/// What was read out of one image. A frame without a usable image has no contacts and no values.
struct FrameReading {
  std::vector<ContactReading> contacts;          ///< the strongest first
  std::optional<double> peak;                    ///< the δσ of the largest |δσ|, S/m
  std::optional<double> sum;                     ///< of δσ over the sheet, S/m mm²
  std::optional<Eigen::Vector2d> centroid_mm;    ///< of the whole image (C4), where it has one
  std::optional<Eigen::Vector2d> centroid25_mm;  ///< after the threshold of 25 % (D.1)

  /// Share of the norm of the voltages' change that the image explains, 0 ... 1 (ExplainedChange).
  std::optional<double> explained;

  bool operator==(const FrameReading&) const = default;
};

/// `change` [pixels] S/m, all finite.
FrameReading frame_reading(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           std::span<const FoundContact> contacts);

}  // namespace ertbench
