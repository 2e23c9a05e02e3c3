#include "bench/studies/collision_detectors.h"

#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

constexpr int most_force_bins = 10;
constexpr double found_share = 0.95;

/// What each of the detector's thresholds may raise, an hour.
std::vector<double> alarms_asked(AlarmRule rule, const CollisionTruth& truth, double per_hour) {
  if (rule != AlarmRule::by_region) return {per_hour};
  std::vector<double> out;
  for (const double share : truth.region_shares) out.push_back(per_hour * share);
  return out;
}

std::vector<Trial> press_trials(const CollisionTruth& truth, const std::vector<char>& alarms) {
  std::vector<Trial> out;
  for (std::size_t f = 0; f < truth.presses.size(); ++f) {
    const PressTruth& press = truth.presses[f];
    if (press.force_N > 0) out.push_back({press.force_N, alarms[f] != 0, press.scene});
  }
  return out;
}

void assess_presses(const CollisionTruth& truth, const AlarmSignal& signal, Detector& detector) {
  const std::vector<char> alarms = alarms_of(signal, values_of(detector.thresholds));
  const std::string key = detector.name() + "press";
  const std::vector<Trial> trials = press_trials(truth, alarms);
  detector.by_force = share_bins(trials, most_force_bins);
  detector.least_N = least_found(trials, found_share, key);
  for (std::size_t region = 0; region < truth.region_shares.size(); ++region) {
    std::vector<Trial> within;
    for (std::size_t f = 0; f < truth.presses.size(); ++f) {
      const PressTruth& press = truth.presses[f];
      if (press.force_N <= 0 || press.region != static_cast<int>(region)) continue;
      within.push_back({press.force_N, alarms[f] != 0, press.scene});
    }
    detector.least_by_region_N.push_back(
        least_found(std::move(within), found_share, key + std::to_string(region)));
  }
  for (std::size_t f = 0; f < truth.presses.size(); ++f) {
    if (truth.presses[f].force_N > 0 && std::isnan(signal.magnitude[f])) {
      ++detector.undefined_presses;
    }
  }
}

void assess_quiet(const CollisionTruth& truth, const AlarmSignal& signal, Detector& detector) {
  const std::vector<char> alarms = alarms_of(signal, values_of(detector.thresholds));
  detector.quiet = {alarm_count(alarms, truth.quiet), truth.quiet.hours()};
  GroupedErrors alarmed(truth.quiet.sequences());
  for (std::size_t s = 0; s < truth.quiet.sequences(); ++s) {
    for (std::size_t f = truth.quiet.first[s]; f < truth.quiet.first[s + 1]; ++f) {
      alarmed.add(s, alarms[f]);
    }
  }
  detector.quiet_alarmed = alarmed.mean(detector.name() + "quiet");
}

ArmOutcome assess_arm(const CollisionTruth& truth, const AlarmSignal& signal,
                      const Detector& detector, const ArmSettings& settings) {
  const std::vector<char> alarms = alarms_of(signal, values_of(detector.thresholds));
  std::vector<ArmRun> runs;
  for (std::size_t s = 0; s < truth.arm_runs.size(); ++s) {
    const std::span<const char> frames(alarms.data() + truth.arm.first[s],
                                       truth.arm.first[s + 1] - truth.arm.first[s]);
    runs.push_back(arm_run(frames, truth.arm_timing, detector.latency_s.value_or(0),
                           truth.arm_runs[s], settings));
  }
  return arm_outcome(std::move(runs), settings, detector.name() + "arm");
}

}  // namespace

const char* name_of(AlarmRule rule) {
  switch (rule) {
    case AlarmRule::by_region:
      return "by region";
    case AlarmRule::one_threshold:
      return "one threshold";
    case AlarmRule::voltage_norm:
      break;
  }
  return "norm of the voltages";
}

Interval FalseAlarms::ci95() const {
  const Interval count = poisson_interval(alarms);
  return {count.low / hours, count.high / hours};
}

std::string Detector::name() const {
  return rule == AlarmRule::voltage_norm ? label : label + ", " + name_of(rule);
}

Detector assess_detector(const std::string& label, AlarmRule rule, const DetectorSignals& signals,
                         const CollisionTruth& truth, double per_hour,
                         std::optional<double> latency_s, const ArmSettings& arm) {
  Detector out;
  out.label = label;
  out.rule = rule;
  out.latency_s = latency_s;
  out.thresholds = fit_thresholds(signals.calibration, truth.calibration,
                                  alarms_asked(rule, truth, per_hour), out.name());
  assess_quiet(truth, signals.quiet, out);
  assess_presses(truth, signals.presses, out);
  out.arm = assess_arm(truth, signals.arm, out, arm);
  return out;
}

std::optional<std::size_t> reference_bin(const std::vector<Detector>& detectors) {
  std::vector<CountedShare> sums;
  for (const Detector& detector : detectors) {
    sums.resize(std::max(sums.size(), detector.by_force.size()));
    for (std::size_t b = 0; b < detector.by_force.size(); ++b) {
      sums[b].count += detector.by_force[b].successes.count;
      sums[b].total += detector.by_force[b].successes.total;
    }
  }
  if (sums.empty()) return std::nullopt;
  const auto distance = [](const CountedShare& sum) {
    return std::abs(sum.count / static_cast<double>(sum.total) - 0.5);
  };
  const auto best = std::min_element(
      sums.begin(), sums.end(),
      [&](const CountedShare& a, const CountedShare& b) { return distance(a) < distance(b); });
  return static_cast<std::size_t>(best - sums.begin());
}

std::vector<OperatingPoint> operating_curve(const Detector& detector,
                                            const DetectorSignals& signals,
                                            const CollisionTruth& truth, const ShareBin& bin) {
  constexpr int steps = 24;  // a factor of 2 in eight steps, the fitted threshold among them
  const std::vector<double> thresholds = values_of(detector.thresholds);
  std::vector<OperatingPoint> out;
  for (int step = steps / 2; step >= -steps; --step) {
    OperatingPoint point;
    point.factor = std::exp2(step / 8.0);
    point.quiet = {alarm_count(alarms_of(signals.quiet, thresholds, point.factor), truth.quiet),
                   truth.quiet.hours()};
    const std::vector<char> alarms = alarms_of(signals.presses, thresholds, point.factor);
    for (const Trial& trial : press_trials(truth, alarms)) {
      if (trial.value >= bin.low && trial.value <= bin.high) point.found.add(trial.success);
    }
    out.push_back(point);
  }
  int most = 0;
  for (const OperatingPoint& point : out) most = std::max(most, point.quiet.alarms);
  // An image that is either empty or a contact has about as many alarms at any factor.
  const auto last = std::find_if(out.rbegin(), out.rend(), [&](const OperatingPoint& point) {
    return point.quiet.alarms >= 0.9 * most;
  });
  if (most > 0) out.erase(last.base(), out.end());
  return out;
}

}  // namespace ertbench
