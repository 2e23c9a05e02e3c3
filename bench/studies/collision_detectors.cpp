#include <algorithm>
#include <cmath>

#include "bench/studies/collision.h"
#include "core/statistics.h"

namespace ertbench {

double ArmSettings::way_m(double speed_m_s, double delay_s) const {
  return speed_m_s * delay_s + speed_m_s * speed_m_s / (2 * deceleration_m_s2);
}

double ArmSettings::peak_force_N(double speed_m_s, double delay_s) const {
  return stiffness_N_mm * 1000 * way_m(speed_m_s, delay_s);
}

double ArmSettings::travel_s(double speed_m_s, double way_m) const {
  const double a = deceleration_m_s2;
  if (way_m < speed_m_s * speed_m_s / a) return 2 * std::sqrt(way_m / a);
  return way_m / speed_m_s + speed_m_s / a;
}

double ArmSettings::detour_s(double speed_m_s, double way_m) const {
  const double back_m = way_m + clearance_mm / 1000;
  const double stopping_s = speed_m_s / (2 * deceleration_m_s2);  // longer than going on
  // The way back is gone again, the arm speeding up as it left off.
  const double again_s = back_m / speed_m_s + speed_m_s / (2 * deceleration_m_s2);
  return stopping_s + travel_s(speed_m_s, back_m) + 2 * travel_s(speed_m_s, aside_mm / 1000) +
         again_s;
}

double ArmSettings::highest_speed_m_s() const {
  return std::sqrt(2 * deceleration_m_s2 * aim_N / (1000 * stiffness_N_mm));
}

std::optional<RaisedAlarm> first_alarm_time(std::span<const char> alarms, const FrameTiming& timing,
                                            double latency_s) {
  const std::size_t frames = alarms.size();
  double free_s = 0;  // from when on the solver can take the next frame
  for (std::size_t n = 0; n < frames; ++n) {
    // Frames that came while the solver was busy are dropped, except the newest.
    while (n + 1 < frames && timing.end_s(static_cast<double>(n + 1)) <= free_s) ++n;
    const double end_s = timing.end_s(static_cast<double>(n));
    free_s = std::max(free_s, end_s) + latency_s;
    if (alarms[n]) return RaisedAlarm{free_s, end_s};
  }
  return std::nullopt;
}

ArmRun delayed_run(double delay_s, const ArmTruth& truth, const ArmSettings& settings) {
  ArmRun run;
  run.truth = truth;
  run.delay_s = delay_s;
  run.peak_N = settings.peak_force_N(truth.speed_m_s, delay_s);
  run.lost_s = settings.detour_s(truth.speed_m_s, settings.way_m(truth.speed_m_s, delay_s));
  run.done = *run.peak_N < settings.limit_N;
  return run;
}

ArmRun arm_run(std::span<const char> alarms, const FrameTiming& timing, double latency_s,
               const ArmTruth& truth, const ArmSettings& settings) {
  ArmRun run;
  run.truth = truth;
  const auto alarm = first_alarm_time(alarms, timing, latency_s);
  if (!alarm) return run;
  if (alarm->frame_end_s <= truth.onset_s) {
    run.needless_stop = true;
    run.lost_s = settings.detour_s(truth.speed_m_s, 0);
    return run;
  }
  run = delayed_run(alarm->time_s - truth.onset_s, truth, settings);
  // A solver without latency looks at every frame as soon as it is there.
  for (std::size_t n = 0; n < alarms.size(); ++n) {
    const double end_s = timing.end_s(static_cast<double>(n));
    if (!alarms[n] || end_s <= truth.onset_s) continue;
    run.of_latency_s = alarm->time_s - end_s;
    break;
  }
  return run;
}

namespace {

/// The delays' part that is the solver's, of all runs with an alarm.
std::optional<Estimate> share_of_latency(const std::vector<ArmRun>& runs, const std::string& name) {
  std::vector<double> latencies;
  std::vector<double> delays;
  for (const ArmRun& run : runs) {
    if (!run.delay_s) continue;
    latencies.push_back(run.of_latency_s);
    delays.push_back(*run.delay_s);
  }
  if (delays.empty()) return std::nullopt;
  const std::optional<RatioOfSums> share = ratio_of_sums(latencies, delays, name);
  return share ? Estimate{share->ratio, share->ci95} : Estimate{};  // where nothing is delayed
}

constexpr int most_force_bins = 10;
constexpr double found_share = 0.95;

/// False alarms an hour that each of the detector's thresholds may raise.
std::vector<double> alarms_asked(AlarmRule rule, const CollisionTruth& truth, double per_hour) {
  if (rule != AlarmRule::by_region) return {per_hour};
  std::vector<double> out;
  for (const double share : truth.region_shares) out.push_back(per_hour * share);
  return out;
}

/// The presses of a region; of all without one.
std::vector<Trial> press_trials(const CollisionTruth& truth, const std::vector<char>& alarms,
                                std::optional<std::size_t> region = {}) {
  std::vector<Trial> out;
  for (std::size_t f = 0; f < truth.presses.size(); ++f) {
    const PressTruth& press = truth.presses[f];
    if (press.force_N <= 0 || (region && press.region != static_cast<int>(*region))) continue;
    out.push_back({press.force_N, alarms[f] != 0, press.scene});
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
    detector.least_by_region_N.push_back(least_found(press_trials(truth, alarms, region),
                                                     found_share, key + std::to_string(region)));
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

ArmOutcome arm_outcome(std::vector<ArmRun> runs, const ArmSettings& settings,
                       const std::string& name) {
  ArmOutcome out;
  out.runs = std::move(runs);
  GroupedErrors delays(out.runs.size());
  GroupedErrors peaks(out.runs.size());
  GroupedErrors losses(out.runs.size());
  std::vector<Trial> slow_enough;  // by slowness, as success grows with it
  for (std::size_t r = 0; r < out.runs.size(); ++r) {
    const ArmRun& run = out.runs[r];
    out.done.add(run.done);
    out.needless.add(run.needless_stop);
    if (run.lost_s) losses.add(r, *run.lost_s);
    if (run.needless_stop) continue;
    const bool within_aim = run.peak_N && *run.peak_N < settings.aim_N;
    delays.add(r, run.delay_s.value_or(ArmOutcome::never_s));
    peaks.add(r, std::min(run.peak_N.value_or(settings.limit_N), settings.limit_N));
    out.under_aim.add(within_aim);
    out.under_limit.add(run.peak_N && *run.peak_N < settings.limit_N);
    slow_enough.push_back({-run.truth.speed_m_s, within_aim, r});
  }
  out.median_delay_s = delays.quantile(0.5, name + "median delay");
  out.p95_delay_s = delays.quantile(0.95, name + "p95 delay");
  out.median_peak_N = peaks.quantile(0.5, name + "median peak");
  out.p95_peak_N = peaks.quantile(0.95, name + "p95 peak");
  out.mean_lost_s = losses.mean(name + "lost");
  out.latency_share = share_of_latency(out.runs, name + "latency");
  out.highest_speed_m_s = least_found(slow_enough, 0.95, name + "speed");
  if (auto& speed = out.highest_speed_m_s) {
    const auto turned = [](const Interval& slowness) {
      return Interval{-slowness.high, -slowness.low};
    };
    *speed = {-speed->value, turned(speed->ci95), turned(speed->reach)};
  }
  return out;
}

const char* name_of(AlarmRule rule) {
  constexpr const char* names[] = {"by region", "one threshold", "norm of the voltages"};
  return names[static_cast<std::size_t>(rule)];
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

}  // namespace ertbench
