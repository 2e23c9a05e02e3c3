#include "bench/live/touch_force.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/studies/sheet_regions.h"

namespace ertbench {
namespace {

std::vector<PressStep> steps_of(const TouchRegions& regions,
                                const std::vector<KnownTouch>& touches) {
  std::vector<PressStep> out;
  for (const KnownTouch& touch : touches) {
    const std::optional<int> area = regions.area(touch.reading);
    if (!area || !touch.reading.sum) continue;
    PressStep step;
    step.area = *area;
    step.force_N = touch.force_N;
    step.sum = std::abs(*touch.reading.sum);
    out.push_back(step);
  }
  return out;
}

AlarmSignal signal_of(const TouchRegions& regions, const std::vector<FrameReading>& readings) {
  AlarmSignal out;
  for (const FrameReading& reading : readings) {
    out.magnitude.push_back(reading.peak ? std::abs(*reading.peak)
                                         : std::numeric_limits<double>::quiet_NaN());
    const std::optional<int> area = regions.area(reading);
    out.region.push_back(area ? regions.region_of()[static_cast<std::size_t>(*area)] : -1);
  }
  return out;
}

}  // namespace

TouchRegions::TouchRegions(const Sensor& sensor)
    : sensor_(sensor), region_of_(area_orbits(*sensor.sheet)) {}

std::optional<int> TouchRegions::area(const FrameReading& reading) const {
  std::optional<Eigen::Vector2d> place_mm = reading.centroid25_mm;
  if (!reading.contacts.empty()) place_mm = reading.contacts.front().place_mm;
  if (!place_mm) return std::nullopt;
  return area_of(*sensor_.sheet, *place_mm);
}

std::vector<double> TouchRegions::shares() const {
  const int regions = *std::max_element(region_of_.begin(), region_of_.end()) + 1;
  std::vector<double> out(static_cast<std::size_t>(regions));
  for (const int region : region_of_) {
    out[static_cast<std::size_t>(region)] += 1 / static_cast<double>(region_of_.size());
  }
  return out;
}

ForceReader::ForceReader(const TouchRegions& regions, const std::vector<KnownTouch>& touches)
    : regions_(regions),
      calibration_(steps_of(regions, touches), Strength::sum, regions.region_of()) {}

std::optional<double> ForceReader::force_N(const FrameReading& reading) const {
  if (reading.contacts.empty() || !reading.sum) return std::nullopt;
  const std::optional<int> area = regions_.area(reading);
  const int region = regions_.region_of()[static_cast<std::size_t>(*area)];
  return calibration_.force_N(region, std::abs(*reading.sum));
}

CollisionSignal::CollisionSignal(const TouchRegions& regions,
                                 const std::vector<FrameReading>& quiet, const FrameRuns& runs,
                                 double false_alarms_per_hour)
    : regions_(regions) {
  std::vector<double> per_hour = regions.shares();
  for (double& one : per_hour) one *= false_alarms_per_hour;
  thresholds_ = values_of(fit_thresholds(signal_of(regions, quiet), runs, per_hour, "live"));
}

bool CollisionSignal::alarm(const FrameReading& reading) const {
  return alarms_of(signal_of(regions_, {reading}), thresholds_)[0] != 0;
}

}  // namespace ertbench
