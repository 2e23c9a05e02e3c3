#include "bench/studies/alarm_thresholds.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "bench/studies/error_statistics.h"

namespace ertbench {
namespace {

constexpr std::size_t least_tail_frames = 30;  ///< of a region for a tail of its own
constexpr std::size_t least_blocks = 20;       ///< of frames that are drawn together

/// A run of frames above the start of the tail.
struct QuietPeak {
  std::size_t frame;  ///< its first
  double excess;
};

/// Quiet magnitudes of the region, or of all where it is -1.
std::vector<double> region_magnitudes(const AlarmSignal& quiet, int region) {
  std::vector<double> out;
  for (std::size_t f = 0; f < quiet.magnitude.size(); ++f) {
    const bool within = region < 0 || quiet.region[f] == region;
    if (within && std::isfinite(quiet.magnitude[f])) out.push_back(quiet.magnitude[f]);
  }
  return out;
}

/// The start of the tail: a hundred frames are above it, or a tenth where there are fewer than a
/// thousand; more where false alarms are allowed so often that they lie among the frames seen.
double tail_start(std::vector<double> magnitudes, double expected_alarms) {
  const std::size_t count = magnitudes.size();
  std::size_t above = std::clamp<std::size_t>(count / 10, 10, 100);
  above = std::max(above, static_cast<std::size_t>(std::min(2 * expected_alarms, 1e9)));
  above = std::min(above, count - 1);
  const auto start = magnitudes.begin() + static_cast<std::ptrdiff_t>(above);
  std::nth_element(magnitudes.begin(), start, magnitudes.end(), std::greater<>());
  return *start;
}

std::vector<QuietPeak> quiet_peaks(const AlarmSignal& quiet, const FrameRuns& runs, int region,
                                   double start) {
  std::vector<QuietPeak> peaks;
  for (std::size_t s = 0; s < runs.sequences(); ++s) {
    bool inside = false;
    for (std::size_t f = runs.first[s]; f < runs.first[s + 1]; ++f) {
      const bool above = (region < 0 || quiet.region[f] == region) && quiet.magnitude[f] > start;
      if (above && !inside) peaks.push_back({f, 0});
      if (above) {
        double& excess = peaks.back().excess;
        excess = std::max(excess, quiet.magnitude[f] - start);
      }
      inside = above;
    }
  }
  return peaks;
}

/// Frames that are resampled together: a sequence, or a part of it where there are few sequences.
struct FrameBlocks {
  std::vector<std::size_t> first;  ///< [blocks]

  explicit FrameBlocks(const FrameRuns& runs) {
    const std::size_t parts = (least_blocks + runs.sequences() - 1) / runs.sequences();
    for (std::size_t s = 0; s < runs.sequences(); ++s) {
      const std::size_t frames = runs.first[s + 1] - runs.first[s];
      const std::size_t cuts = std::min(parts, std::max<std::size_t>(frames, 1));
      for (std::size_t p = 0; p < cuts; ++p) first.push_back(runs.first[s] + frames * p / cuts);
    }
  }
  std::size_t block_of(std::size_t frame) const {
    return static_cast<std::size_t>(std::ranges::upper_bound(first, frame) - first.begin()) - 1;
  }
};

/// Sums over blocks from which a tail is estimated.
struct TailSums {
  double peaks = 0;
  double excess = 0;
  double hours = 0;

  TailSums& operator+=(const TailSums& other) {
    peaks += other.peaks;
    excess += other.excess;
    hours += other.hours;
    return *this;
  }
  QuietTail tail(double start) const {
    if (peaks == 0) return {start, 0, 0, 0};
    return {start, peaks / hours, excess / peaks, static_cast<int>(peaks)};
  }
};

AlarmThreshold fit_region(const AlarmSignal& quiet, const FrameRuns& runs, int region,
                          double per_hour, const std::string& name) {
  const std::vector<double> magnitudes = region_magnitudes(quiet, region);
  AlarmThreshold out;
  out.per_hour = per_hour;
  out.frames = magnitudes.size();
  if (magnitudes.empty()) return out;
  const double start = tail_start(magnitudes, per_hour * runs.hours());

  const FrameBlocks blocks(runs);
  std::vector<TailSums> sums(blocks.first.size());
  for (std::size_t b = 0; b < sums.size(); ++b) {
    const std::size_t end = b + 1 < sums.size() ? blocks.first[b + 1] : runs.frames();
    sums[b].hours = static_cast<double>(end - blocks.first[b]) / runs.frame_rate / 3600;
  }
  for (const QuietPeak& peak : quiet_peaks(quiet, runs, region, start)) {
    sums[blocks.block_of(peak.frame)] += {1, peak.excess, 0};
  }
  TailSums all;
  for (const TailSums& block : sums) all += block;
  out.tail = all.tail(start);
  out.value = out.tail.exceeded(per_hour);
  out.ci95 = bootstrap_interval_of_groups(
      sums.size(),
      [&](std::span<const std::size_t> drawn) {
        TailSums sum;
        for (const std::size_t block : drawn) sum += sums[block];
        return sum.tail(start).exceeded(per_hour);
      },
      name);
  return out;
}

/// P(X <= count) or, `upper`, P(X >= count) of a Poisson number with this mean. Summed from the
/// count outwards, which is where the terms are largest if the mean lies on the other side.
double poisson_tail(int count, double mean, bool upper) {
  double term = std::exp(count * std::log(mean) - mean - std::lgamma(count + 1.0));
  double sum = 0;
  for (double k = count; k >= 0 && term > 0; k += upper ? 1 : -1) {
    sum += term;
    if (term < 1e-12 * sum) break;
    term *= upper ? mean / (k + 1) : k / mean;
  }
  return sum;
}

/// The mean between the two at which the tail is 2.5 %, by bisection.
double poisson_limit(int count, double low, double high, bool upper) {
  for (int step = 0; step < 60; ++step) {
    const double mean = (low + high) / 2;
    const bool beyond = poisson_tail(count, mean, upper) < 0.025;  // too far from the count
    (beyond == upper ? low : high) = mean;
  }
  return (low + high) / 2;
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
  const int regions = *std::ranges::max_element(region_of_) + 1;
  std::vector<double> out(static_cast<std::size_t>(regions));
  for (const int region : region_of_) {
    out[static_cast<std::size_t>(region)] += 1 / static_cast<double>(region_of_.size());
  }
  return out;
}

AlarmSignal TouchRegions::signal(std::span<const FrameReading> readings) const {
  AlarmSignal out;
  for (const FrameReading& reading : readings) {
    out.magnitude.push_back(reading.peak ? std::abs(*reading.peak)
                                         : std::numeric_limits<double>::quiet_NaN());
    const std::optional<int> area = this->area(reading);
    out.region.push_back(area ? region_of_[static_cast<std::size_t>(*area)] : -1);
  }
  return out;
}

double QuietTail::exceeded(double per_hour) const {
  if (peaks == 0) return start;
  return std::max(0.0, start + mean_excess * std::log(peaks_per_hour / per_hour));
}

std::vector<AlarmThreshold> fit_thresholds(const AlarmSignal& quiet, const FrameRuns& runs,
                                           std::span<const double> per_hour,
                                           const std::string& name) {
  if (runs.frames() == 0) throw std::invalid_argument("thresholds of no quiet frame");
  double total = 0;
  for (const double one : per_hour) total += one;
  std::vector<AlarmThreshold> out;
  for (std::size_t r = 0; r < per_hour.size(); ++r) {
    const int region = static_cast<int>(r);
    const std::size_t frames = region_magnitudes(quiet, region).size();
    const bool borrowed = frames < least_tail_frames;
    const std::string key = name + "region" + std::to_string(r);
    out.push_back(
        fit_region(quiet, runs, borrowed ? -1 : region, borrowed ? total : per_hour[r], key));
    out.back().borrowed = borrowed && per_hour.size() > 1;
    out.back().per_hour = per_hour[r];
    out.back().frames = frames;
  }
  return out;
}

std::vector<double> values_of(std::span<const AlarmThreshold> thresholds) {
  std::vector<double> out;
  for (const AlarmThreshold& threshold : thresholds) out.push_back(threshold.value);
  return out;
}

std::vector<char> alarms_of(const AlarmSignal& signal, std::span<const double> thresholds) {
  const double largest = *std::ranges::max_element(thresholds);
  std::vector<char> out(signal.magnitude.size());
  for (std::size_t f = 0; f < out.size(); ++f) {
    const int region = signal.region[f];
    const double threshold = region < 0 ? largest : thresholds[static_cast<std::size_t>(region)];
    // Without any noise the threshold is 0, and so is what does not touch.
    out[f] = signal.magnitude[f] >= threshold && signal.magnitude[f] > 0;
  }
  return out;
}

int alarm_count(std::span<const char> alarms, const FrameRuns& runs) {
  int count = 0;
  for (std::size_t s = 0; s < runs.sequences(); ++s) {
    for (std::size_t f = runs.first[s]; f < runs.first[s + 1]; ++f) {
      if (alarms[f] && (f == runs.first[s] || !alarms[f - 1])) ++count;
    }
  }
  return count;
}

Interval poisson_interval(int count) {
  if (count < 0) throw std::invalid_argument("a count below zero");
  const double reach = 4 * std::sqrt(count + 1.0) + 4;
  Interval out;
  if (count > 0) out.low = poisson_limit(count, std::max(0.0, count - reach), count, true);
  out.high = poisson_limit(count, count, count + reach, false);
  return out;
}

}  // namespace ertbench
