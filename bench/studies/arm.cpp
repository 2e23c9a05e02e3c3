#include "bench/studies/arm.h"

#include <algorithm>
#include <cmath>

#include "core/bootstrap.h"

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
    // What came while the solver was busy is dropped, but for the newest.
    while (n + 1 < frames && timing.end_s(static_cast<double>(n + 1)) <= free_s) ++n;
    const double end_s = timing.end_s(static_cast<double>(n));
    free_s = std::max(free_s, end_s) + latency_s;
    if (alarms[n]) return RaisedAlarm{free_s, end_s};
  }
  return std::nullopt;
}

ArmRun undelayed_run(const ArmTruth& truth, const ArmSettings& settings) {
  ArmRun run;
  run.truth = truth;
  run.delay_s = 0;
  run.peak_N = settings.peak_force_N(truth.speed_m_s, 0);
  run.lost_s = settings.detour_s(truth.speed_m_s, settings.way_m(truth.speed_m_s, 0));
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
  run.delay_s = alarm->time_s - truth.onset_s;
  // A solver without latency looks at every frame as soon as it is there.
  for (std::size_t n = 0; n < alarms.size(); ++n) {
    const double end_s = timing.end_s(static_cast<double>(n));
    if (!alarms[n] || end_s <= truth.onset_s) continue;
    run.of_latency_s = alarm->time_s - end_s;
    break;
  }
  run.peak_N = settings.peak_force_N(truth.speed_m_s, *run.delay_s);
  run.lost_s = settings.detour_s(truth.speed_m_s, settings.way_m(truth.speed_m_s, *run.delay_s));
  run.done = *run.peak_N < settings.limit_N;
  return run;
}

namespace {

/// The delays' part that is the solver's, of all runs with an alarm.
std::optional<Estimate> share_of_latency(const std::vector<ArmRun>& runs, const std::string& name) {
  std::vector<const ArmRun*> alarmed;
  for (const ArmRun& run : runs) {
    if (run.delay_s) alarmed.push_back(&run);
  }
  if (alarmed.empty()) return std::nullopt;
  const auto share = [&](std::span<const std::size_t> drawn) {
    double latency = 0;
    double delay = 0;
    for (const std::size_t i : drawn) {
      latency += alarmed[i]->of_latency_s;
      delay += *alarmed[i]->delay_s;
    }
    return delay > 0 ? latency / delay : 0;
  };
  std::vector<std::size_t> all(alarmed.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return Estimate{share(all), bootstrap_interval_of_groups(all.size(), share, name)};
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

}  // namespace ertbench
