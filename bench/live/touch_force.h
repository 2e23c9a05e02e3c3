#pragma once

#include <optional>
#include <vector>

#include "bench/contacts/frame_reading.h"
#include "bench/studies/alarm_thresholds.h"
#include "bench/studies/sensitivity.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The regions into which the sheet's symmetries divide it (see area_orbits), and which of them a
/// frame is about.
class TouchRegions {
 public:
  explicit TouchRegions(const Sensor& sensor);

  /// The area in which the strongest contact lies, without one the centroid of the image; nothing
  /// where the image shows nothing.
  std::optional<int> area(const FrameReading& reading) const;
  const std::vector<int>& region_of() const { return region_of_; }  ///< [areas]
  std::vector<double> shares() const;                               ///< [regions] of all areas

 private:
  Sensor sensor_;
  std::vector<int> region_of_;
};

/// A frame whose force is known.
struct KnownTouch {
  FrameReading reading;
  double force_N = 0;
};

/// From what an image says to the force of all touches together, as the study of sensitivity does:
/// the integral of δσ over the sheet, region by region made monotone in the force and read
/// backwards. Beyond the forces that it was made with their ends stand.
class ForceReader {
 public:
  ForceReader(const TouchRegions& regions, const std::vector<KnownTouch>& touches);
  /// Nothing where the image shows no touch, or one where no force was known.
  std::optional<double> force_N(const FrameReading& reading) const;

 private:
  const TouchRegions& regions_;
  ForceCalibration calibration_;
};

/// The collision signal of the study of collisions: the largest |δσ| of an image against a
/// threshold for the region of its touch.
class CollisionSignal {
 public:
  /// `quiet`: what was read out of frames in which nothing touches, one after the other.
  CollisionSignal(const TouchRegions& regions, const std::vector<FrameReading>& quiet,
                  const FrameRuns& runs, double false_alarms_per_hour);
  bool alarm(const FrameReading& reading) const;
  const std::vector<double>& thresholds() const { return thresholds_; }  ///< [regions] S/m

 private:
  const TouchRegions& regions_;
  std::vector<double> thresholds_;
};

}  // namespace ertbench
