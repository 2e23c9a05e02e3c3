#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/score/image_contacts.h"
#include "core/statistics.h"
#include "forward/sheet/sensor.h"

/// Alarm thresholds from frames without a touch, and the alarms that they raise.
namespace ertbench {

/// A detector's signal, frame by frame: any number that grows with a touch, in the detector's own
/// unit.
struct AlarmSignal {
  std::vector<double> magnitude;  ///< [frames]; not a number where there is none: never an alarm
  /// [frames] whose threshold holds; -1 where the frame names no region: the largest one holds.
  std::vector<int> region;
};

/// The regions into which the sheet's symmetries divide it (see area_orbits).
class TouchRegions {
 public:
  explicit TouchRegions(const Sensor& sensor);

  /// The area of the strongest contact or, without contacts, of the image's centroid; nothing if
  /// the image is empty.
  std::optional<int> area(const FrameReading& reading) const;
  const std::vector<int>& region_of() const { return region_of_; }  ///< [areas]
  std::vector<double> shares() const;  ///< [regions] each region's share of the areas
  /// The largest |δσ| of each image, and the region of the area that it touches.
  AlarmSignal signal(std::span<const FrameReading> readings) const;

 private:
  Sensor sensor_;
  std::vector<int> region_of_;
};

/// The frames of a set of sequences, one sequence behind the other.
struct FrameRuns {
  std::vector<std::size_t> first;  ///< [sequences + 1] the first frame of each, and their count
  double frame_rate = 1;           ///< 1/s

  std::size_t sequences() const { return first.size() - 1; }
  std::size_t frames() const { return first.back(); }
  double hours() const { return static_cast<double>(frames()) / frame_rate / 3600; }
};

/// The tail of quiet magnitudes in a region. Frames above `start` that follow each other are one
/// peak; the excesses of peaks over `start` are exponential (peaks over threshold, Davison & Smith
/// 1990, with the generalised Pareto distribution's shape 0).
struct QuietTail {
  double start = 0;
  double peaks_per_hour = 0;  ///< above `start`
  double mean_excess = 0;     ///< the exponential's maximum-likelihood scale
  int peaks = 0;              ///< that it was fitted to

  /// The level that peaks exceed `per_hour` times an hour: start + mean_excess ln(peaks_per_hour /
  /// per_hour); never under 0, which a magnitude cannot be.
  double exceeded(double per_hour) const;
};

struct AlarmThreshold {
  double value = 0;
  Interval ci95;           ///< by the bootstrap over blocks of frames, `start` being kept
  double per_hour = 0;     ///< false alarms that were asked for
  std::size_t frames = 0;  ///< quiet frames in the region
  QuietTail tail;
  bool borrowed = false;  ///< from all regions: too few quiet frames name this one
};

/// A threshold for each region, so that peaks of quiet frames exceed it so often an hour.
/// `per_hour` [regions]. The shape is fixed at 0 because it is that of all noise with Gaussian
/// tails, and because the number asked for lies far beyond what was seen: a shape fitted to a
/// hundred peaks is off by a tenth, which makes the false alarms uncertain by orders of magnitude.
/// Lighter tails give fewer false alarms than asked for, heavier ones (drift, faults) more.
/// `name` keys the random numbers. Throws std::invalid_argument for no frame.
std::vector<AlarmThreshold> fit_thresholds(const AlarmSignal& quiet, const FrameRuns& runs,
                                           std::span<const double> per_hour,
                                           const std::string& name);

std::vector<double> values_of(std::span<const AlarmThreshold> thresholds);

/// [frames] whether the magnitude reaches the threshold of its region.
std::vector<char> alarms_of(const AlarmSignal& signal, std::span<const double> thresholds);

/// Alarms, each of one frame or of several that follow each other in a sequence.
int alarm_count(std::span<const char> alarms, const FrameRuns& runs);

/// The exact 95 % interval of the mean of a Poisson count (Garwood 1936).
Interval poisson_interval(int count);

}  // namespace ertbench
