#include <nlohmann/json.hpp>

#include "bench/studies/collision.h"
#include "bench/studies/error_statistics.h"
#include "bench/table/table.h"
#include "core/files.h"

namespace ertbench {
namespace {

nlohmann::json interval_json(const Interval& interval) { return {interval.low, interval.high}; }

nlohmann::json share_json(const CountedShare& share) {
  nlohmann::json out = to_json(share.share());
  if (share.total > 0) out.update({{"count", share.count}, {"total", share.total}});
  return out;
}

/// A value beyond its reach is null: nowhere found, at no speed. At the other end of the reach it
/// stands for that value and all before it.
nlohmann::json least_json(const std::optional<LeastFound>& found) {
  if (!found) return nullptr;
  const auto number = [&](double value) {
    const bool within = value >= found->reach.low && value <= found->reach.high;
    return within ? nlohmann::json(value) : nlohmann::json();
  };
  return {{"value", number(found->value)},
          {"ci95", {number(found->ci95.low), number(found->ci95.high)}},
          {"reach", interval_json(found->reach)}};
}

/// An endless delay is null.
nlohmann::json delay_json(const std::optional<Estimate>& delay_s) {
  if (!delay_s) return nullptr;
  const auto number = [](double seconds) {
    return seconds < ArmOutcome::never_s ? nlohmann::json(seconds) : nlohmann::json();
  };
  return {{"value", number(delay_s->value)},
          {"ci95", {number(delay_s->ci95.low), number(delay_s->ci95.high)}}};
}

nlohmann::json arm_json(const ArmOutcome& arm) {
  return {{"median_delay_s", delay_json(arm.median_delay_s)},
          {"p95_delay_s", delay_json(arm.p95_delay_s)},
          {"latency_share", to_json(arm.latency_share)},
          {"median_peak_N", to_json(arm.median_peak_N)},
          {"mean_lost_s", to_json(arm.mean_lost_s)},
          {"p95_peak_N", to_json(arm.p95_peak_N)},
          {"under_aim", share_json(arm.under_aim)},
          {"under_limit", share_json(arm.under_limit)},
          {"done", share_json(arm.done)},
          {"needless_stops", share_json(arm.needless)},
          {"highest_speed_m_s", least_json(arm.highest_speed_m_s)}};
}

nlohmann::json false_alarms_json(const FalseAlarms& quiet) {
  return {{"alarms", quiet.alarms},
          {"hours", quiet.hours},
          {"per_hour", quiet.per_hour()},
          {"ci95", interval_json(quiet.ci95())}};
}

nlohmann::json thresholds_json(const Detector& detector) {
  nlohmann::json out = nlohmann::json::array();
  for (std::size_t r = 0; r < detector.thresholds.size(); ++r) {
    const AlarmThreshold& threshold = detector.thresholds[r];
    const bool by_region = detector.rule == AlarmRule::by_region;
    out.push_back({{"region", by_region ? roman(static_cast<int>(r)) : "all"},
                   {"value", threshold.value},
                   {"ci95", interval_json(threshold.ci95)},
                   {"asked_per_hour", threshold.per_hour},
                   {"frames", threshold.frames},
                   {"of_whole_sheet", threshold.borrowed},
                   {"tail",
                    {{"start", threshold.tail.start},
                     {"peaks", threshold.tail.peaks},
                     {"peaks_per_hour", threshold.tail.peaks_per_hour},
                     {"mean_excess", threshold.tail.mean_excess}}}});
  }
  return out;
}

nlohmann::json detector_json(const Detector& detector) {
  nlohmann::json out = {{"detector", detector.label}, {"alarm_by", name_of(detector.rule)}};
  if (!detector.failure.empty()) {
    out["failure"] = detector.failure;
    return out;
  }
  out["latency_s"] = detector.latency_s ? nlohmann::json(*detector.latency_s) : nlohmann::json();
  out["thresholds"] = thresholds_json(detector);
  out["false_alarms"] = false_alarms_json(detector.quiet);
  out["quiet_time_in_alarm"] = to_json(detector.quiet_alarmed);
  out["undefined_presses"] = detector.undefined_presses;
  out["least_force_N"] = least_json(detector.least_N);
  for (std::size_t r = 0; r < detector.least_by_region_N.size(); ++r) {
    out["least_force_by_region_N"][roman(static_cast<int>(r))] =
        least_json(detector.least_by_region_N[r]);
  }
  out["detection"] = nlohmann::json::array();
  for (const ShareBin& bin : detector.by_force) {
    out["detection"].push_back(
        {{"force_N", {bin.low, bin.high}}, {"found", share_json(bin.successes)}});
  }
  out["curve"] = nlohmann::json::array();
  for (const OperatingPoint& point : detector.curve) {
    out["curve"].push_back({{"factor", point.factor},
                            {"false_alarms", false_alarms_json(point.quiet)},
                            {"found", share_json(point.found)}});
  }
  out["arm"] = arm_json(detector.arm);
  return out;
}

/// Begins a line of a file for programs.
std::vector<Cell> data_row(const Detector& detector) {
  return {detector.label, name_of(detector.rule)};
}

void add_estimate(const std::optional<Estimate>& estimate, std::vector<Cell>& row) {
  const bool any = estimate.has_value();
  row.push_back(exact_cell(any ? std::optional(estimate->value) : std::nullopt));
  row.push_back(exact_cell(any ? std::optional(estimate->ci95.low) : std::nullopt));
  row.push_back(exact_cell(any ? std::optional(estimate->ci95.high) : std::nullopt));
}

TableSection force_data(const CollisionResults& results) {
  TableSection section;
  section.columns = {"detector", "alarm_by", "force_low_N", "force_high_N", "force_mean_N",
                     "presses",  "found",    "share",       "ci_low",       "ci_high"};
  for (const Detector& detector : results.detectors) {
    for (const ShareBin& bin : detector.by_force) {
      std::vector<Cell> row = data_row(detector);
      for (const double force : {bin.low, bin.high, bin.mean}) row.push_back(exact_cell(force));
      row.emplace_back(std::to_string(bin.successes.total));
      row.emplace_back(std::to_string(bin.successes.count));
      add_estimate(bin.successes.share(), row);
      section.rows.push_back(std::move(row));
    }
  }
  return section;
}

TableSection curve_data(const CollisionResults& results) {
  TableSection section;
  section.columns = {"detector",    "alarm_by",     "factor",          "false_alarms",
                     "hours",       "per_hour",     "per_hour_ci_low", "per_hour_ci_high",
                     "found_share", "found_ci_low", "found_ci_high"};
  for (const Detector& detector : results.detectors) {
    for (const OperatingPoint& point : detector.curve) {
      std::vector<Cell> row = data_row(detector);
      row.push_back(exact_cell(point.factor));
      row.emplace_back(std::to_string(point.quiet.alarms));
      row.push_back(exact_cell(point.quiet.hours));
      add_estimate(Estimate{point.quiet.per_hour(), point.quiet.ci95()}, row);
      add_estimate(point.found.share(), row);
      section.rows.push_back(std::move(row));
    }
  }
  return section;
}

TableSection run_data(const CollisionResults& results) {
  TableSection section;
  section.columns = {"detector", "alarm_by",        "run",    "speed_m_s",     "onset_s",
                     "delay_s",  "delay_latency_s", "peak_N", "needless_stop", "done"};
  for (const Detector& detector : results.detectors) {
    for (std::size_t r = 0; r < detector.arm.runs.size(); ++r) {
      const ArmRun& run = detector.arm.runs[r];
      std::vector<Cell> row = data_row(detector);
      row.emplace_back(std::to_string(r));
      row.push_back(exact_cell(run.truth.speed_m_s));
      row.push_back(exact_cell(run.truth.onset_s));
      row.push_back(exact_cell(run.delay_s));
      row.push_back(exact_cell(run.delay_s ? std::optional(run.of_latency_s) : std::nullopt));
      row.push_back(exact_cell(run.peak_N));
      row.emplace_back(run.needless_stop ? "1" : "0");
      row.emplace_back(run.done ? "1" : "0");
      section.rows.push_back(std::move(row));
    }
  }
  return section;
}

}  // namespace

nlohmann::json collision_json(const CollisionResults& results) {
  nlohmann::json out = {{"condition", results.condition},
                        {"false_alarms_asked_per_hour", results.per_hour},
                        {"calibration_hours", results.calibration_hours},
                        {"frame_rate", results.frame_rate},
                        {"stiffness_N_mm", results.arm.stiffness_N_mm},
                        {"deceleration_m_s2", results.arm.deceleration_m_s2},
                        {"aim_N", results.arm.aim_N},
                        {"limit_N", results.arm.limit_N},
                        {"highest_speed_without_delay_m_s", results.arm.highest_speed_m_s()},
                        {"without_delay", arm_json(results.undelayed)}};
  for (std::size_t r = 0; r < results.region_areas.size(); ++r) {
    out["region_areas"][roman(static_cast<int>(r))] = results.region_areas[r];
  }
  out["detectors"] = nlohmann::json::array();
  for (const Detector& detector : results.detectors) {
    out["detectors"].push_back(detector_json(detector));
  }
  return out;
}

void write_collision_data(const CollisionResults& results, const std::filesystem::path& folder,
                          const std::string& name) {
  write_file_atomically(folder / (name + "_force.csv"), csv_of(force_data(results)));
  write_file_atomically(folder / (name + "_curve.csv"), csv_of(curve_data(results)));
  write_file_atomically(folder / (name + "_runs.csv"), csv_of(run_data(results)));
}

}  // namespace ertbench
