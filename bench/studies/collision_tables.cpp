#include <functional>
#include <iterator>

#include "bench/studies/collision.h"
#include "bench/studies/columns.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// A value and its interval, each as `text` says it. CSV files have `value`.
Cell worded_cell(const Estimate& estimate, std::optional<double> value,
                 const std::function<std::string(double)>& text) {
  Cell cell(text(estimate.value));
  cell.value = value;
  cell.interval = interval_text(text(estimate.ci95.low), text(estimate.ci95.high));
  return cell;
}

Cell percent_cell(const CountedShare& share) {
  Cell cell = estimate_cell(scaled(share.share(), 100), 1);
  if (share.total > 0) {
    cell.lines = {std::to_string(share.count) + " of " + std::to_string(share.total)};
  }
  return cell;
}

Cell three_digits_cell(double value, const Interval& ci95) {
  return worded_cell({value, ci95}, value, three_digits);
}

/// A least force, N.
Cell least_force_cell(const std::optional<LeastFound>& found) {
  if (!found) return "—";
  const Interval reach = found->reach;
  const auto text = [reach](double force_N) {
    if (force_N > reach.high) return "> " + fixed(reach.high, 2);
    return (force_N <= reach.low ? "≤ " : "") + fixed(std::max(force_N, reach.low), 2);
  };
  return worded_cell({found->value, found->ci95},
                     found->value <= reach.high ? std::optional(found->value) : std::nullopt, text);
}

/// A highest speed, m/s.
Cell highest_speed_cell(const std::optional<LeastFound>& found) {
  if (!found) return "—";
  const Interval reach = found->reach;
  const auto text = [reach](double speed_m_s) {
    if (speed_m_s < reach.low) return "< " + fixed(reach.low, 3);
    return (speed_m_s >= reach.high ? "≥ " : "") + fixed(std::min(speed_m_s, reach.high), 3);
  };
  return worded_cell({found->value, found->ci95},
                     found->value >= reach.low ? std::optional(found->value) : std::nullopt, text);
}

Cell delay_cell(const std::optional<Estimate>& delay_s) {
  if (!delay_s) return "—";
  const bool ends = delay_s->value < ArmOutcome::never_s;
  return worded_cell(
      *delay_s, ends ? std::optional(1000 * delay_s->value) : std::nullopt, [](double seconds) {
        return seconds < ArmOutcome::never_s ? fixed(1000 * seconds, 1) : std::string("never");
      });
}

Cell peak_cell(const std::optional<Estimate>& peak_N, double limit_N) {
  if (!peak_N) return "—";
  return worded_cell(*peak_N, peak_N->value, [limit_N](double force_N) {
    return (force_N < limit_N ? "" : "≥ ") + fixed(force_N, 1);
  });
}

json interval_json(const Interval& interval) { return {interval.low, interval.high}; }

json share_json(const CountedShare& share) {
  json out = to_json(share.share());
  if (share.total > 0) out.update({{"count", share.count}, {"total", share.total}});
  return out;
}

/// A value beyond its reach is null: detected nowhere, at no speed. At the other end of the reach
/// it stands for that value and all before it.
json least_json(const std::optional<LeastFound>& found) {
  if (!found) return nullptr;
  const auto number = [&](double value) {
    const bool within = value >= found->reach.low && value <= found->reach.high;
    return within ? json(value) : json();
  };
  return {{"value", number(found->value)},
          {"ci95", {number(found->ci95.low), number(found->ci95.high)}},
          {"reach", interval_json(found->reach)}};
}

/// An endless delay is null.
json delay_json(const std::optional<Estimate>& delay_s) {
  if (!delay_s) return nullptr;
  const auto number = [](double seconds) {
    return seconds < ArmOutcome::never_s ? json(seconds) : json();
  };
  return {{"value", number(delay_s->value)},
          {"ci95", {number(delay_s->ci95.low), number(delay_s->ci95.high)}}};
}

using ArmColumn = StudyColumn<ArmOutcome>;

ArmColumn delay_column(const std::string& key, std::optional<Estimate> ArmOutcome::*delay_s) {
  return ArmColumn::estimate(key, delay_s, 1)
      .shown([=](const ArmOutcome& arm) { return delay_cell(arm.*delay_s); })
      .json([=](const ArmOutcome& arm) { return delay_json(arm.*delay_s); });
}

ArmColumn peak_column(const std::string& key, std::optional<Estimate> ArmOutcome::*peak_N,
                      double limit_N) {
  return ArmColumn::estimate(key, peak_N, 1).shown([=](const ArmOutcome& arm) {
    return peak_cell(arm.*peak_N, limit_N);
  });
}

ArmColumn share_column(const std::string& key, CountedShare ArmOutcome::*share) {
  return ArmColumn::estimate(
             key, [=](const ArmOutcome& arm) { return (arm.*share).share(); }, 1)
      .shown([=](const ArmOutcome& arm) { return percent_cell(arm.*share); })
      .json([=](const ArmOutcome& arm) { return share_json(arm.*share); });
}

/// Outcomes of all runs of the arm, for the table and summary.json.
StudyColumns<ArmOutcome> arm_columns(const ArmSettings& settings) {
  return {
      delay_column("median_delay_s", &ArmOutcome::median_delay_s).table("median delay (ms)"),
      delay_column("p95_delay_s", &ArmOutcome::p95_delay_s).table("95 % delay (ms)"),
      ArmColumn::estimate("latency_share", &ArmOutcome::latency_share, 1, 100)
          .table("of it latency (%)"),
      peak_column("median_peak_N", &ArmOutcome::median_peak_N, settings.limit_N)
          .table("median peak (N)", 1),
      peak_column("p95_peak_N", &ArmOutcome::p95_peak_N, settings.limit_N)
          .table("95 % peak (N)", 1),
      share_column("under_aim", &ArmOutcome::under_aim)
          .table("under " + number_text(settings.aim_N) + " N (%)", 1),
      share_column("under_limit", &ArmOutcome::under_limit)
          .table("under " + number_text(settings.limit_N) + " N (%)", 2),
      share_column("done", &ArmOutcome::done).table("tasks done (%)", 2),
      ArmColumn::estimate("mean_lost_s", &ArmOutcome::mean_lost_s, 2).table("time lost (s)", 2),
      share_column("needless_stops", &ArmOutcome::needless).table("needless stops (%)", 2),
      ArmColumn::count("highest_speed_m_s", [](const ArmOutcome&) { return std::nullopt; })
          .shown([](const ArmOutcome& arm) { return highest_speed_cell(arm.highest_speed_m_s); })
          .json([](const ArmOutcome& arm) { return least_json(arm.highest_speed_m_s); })
          .table("highest speed (m/s)", 2)};
}

json false_alarms_json(const FalseAlarms& quiet) {
  return {{"alarms", quiet.alarms},
          {"hours", quiet.hours},
          {"per_hour", quiet.per_hour()},
          {"ci95", interval_json(quiet.ci95())}};
}

json thresholds_json(const Detector& detector) {
  json out = json::array();
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

json detector_json(const Detector& detector, const ArmSettings& settings) {
  json out = {{"detector", detector.label}, {"alarm_by", name_of(detector.rule)}};
  if (!detector.failure.empty()) {
    out["failure"] = detector.failure;
    return out;
  }
  out["latency_s"] = detector.latency_s ? json(*detector.latency_s) : json();
  out["thresholds"] = thresholds_json(detector);
  out["false_alarms"] = false_alarms_json(detector.quiet);
  out["quiet_time_in_alarm"] = to_json(detector.quiet_alarmed);
  out["undefined_presses"] = detector.undefined_presses;
  out["least_force_N"] = least_json(detector.least_N);
  for (std::size_t r = 0; r < detector.least_by_region_N.size(); ++r) {
    out["least_force_by_region_N"][roman(static_cast<int>(r))] =
        least_json(detector.least_by_region_N[r]);
  }
  out["detection"] = json::array();
  for (const ShareBin& bin : detector.by_force) {
    out["detection"].push_back(
        {{"force_N", {bin.low, bin.high}}, {"found", share_json(bin.successes)}});
  }
  out["arm"] = arm_columns(settings).json(detector.arm);
  return out;
}

/// A table with a row for each detector: its names, then what `fill` adds, or why there is nothing.
template <typename Fill>
TableSection detector_table(const CollisionResults& results, const std::string& caption,
                            const std::vector<Column>& columns, const Fill& fill) {
  TableSection section;
  section.caption = caption;
  section.columns = {{"detector", Align::left}, {"alarm by", Align::left}};
  section.columns.insert(section.columns.end(), columns.begin(), columns.end());
  for (const Detector& detector : results.detectors) {
    const bool solver = detector.rule != AlarmRule::voltage_norm;
    std::vector<Cell>& row = section.rows.emplace_back();
    row = {detector.label, solver ? name_of(detector.rule) : "one threshold, no solver"};
    if (detector.failure.empty()) {
      fill(detector, row);
    } else {
      row.front().lines = {detector.failure};
    }
    if (row.size() < section.columns.size()) row.resize(section.columns.size(), "—");
  }
  return section;
}

TableSection quiet_table(const CollisionResults& results) {
  double hours = 0;
  for (const Detector& detector : results.detectors) hours = std::max(hours, detector.quiet.hours);
  const std::string caption =
      "False alarms where nothing touches: " + results.condition + "; " +
      number_text(results.per_hour) + " an hour asked for, thresholds set on " +
      three_digits(results.calibration_hours) + " h, tried on other " + three_digits(hours) + " h";
  return detector_table(results, caption, {"alarms", "an hour", "quiet time in alarm (%)"},
                        [](const Detector& detector, std::vector<Cell>& row) {
                          const FalseAlarms& quiet = detector.quiet;
                          row.emplace_back(std::to_string(quiet.alarms));
                          row.push_back(three_digits_cell(quiet.per_hour(), quiet.ci95()));
                          row.push_back(estimate_cell(scaled(detector.quiet_alarmed, 100), 3));
                        });
}

std::vector<Column> region_columns(const CollisionResults& results) {
  std::vector<Column> columns = {"whole sheet"};
  for (std::size_t r = 0; r < results.region_areas.size(); ++r) {
    columns.emplace_back(roman(static_cast<int>(r)));
  }
  return columns;
}

TableSection threshold_table(const CollisionResults& results) {
  const std::string caption = "Thresholds: " + results.condition +
                              "; largest |δσ| in mS/m by region, norm of the voltage change in mV";
  return detector_table(
      results, caption, region_columns(results),
      [](const Detector& detector, std::vector<Cell>& row) {
        if (detector.rule == AlarmRule::by_region) row.emplace_back("—");
        for (const AlarmThreshold& threshold : detector.thresholds) {
          row.push_back(three_digits_cell(1000 * threshold.value,
                                          {1000 * threshold.ci95.low, 1000 * threshold.ci95.high}));
          if (threshold.borrowed) row.back().lines = {"of the whole sheet"};
        }
      });
}

TableSection least_force_table(const CollisionResults& results) {
  std::vector<Column> regions = region_columns(results);
  regions.emplace_back("undefined frames");
  return detector_table(
      results, "Least force that is detected in 95 % of the presses, N: " + results.condition,
      regions, [](const Detector& detector, std::vector<Cell>& row) {
        row.push_back(least_force_cell(detector.least_N));
        for (const auto& least_N : detector.least_by_region_N) {
          row.push_back(least_force_cell(least_N));
        }
        row.emplace_back(std::to_string(detector.undefined_presses));
      });
}

TableSection arm_runs_table(const CollisionResults& results) {
  const ArmSettings& arm = results.arm;
  const StudyColumns<ArmOutcome> columns = arm_columns(arm);
  const std::string caption = "An arm runs into an obstacle: " + results.condition + "; " +
                              number_text(results.frame_rate) + " frames a second, " +
                              number_text(arm.stiffness_N_mm) + " N/mm, " +
                              number_text(arm.deceleration_m_s2) + " m/s²";
  TableSection section = detector_table(
      results, caption, columns.titles({"latency (ms)"}),
      [&](const Detector& detector, std::vector<Cell>& row) {
        row.push_back(number_cell(
            detector.latency_s ? std::optional(1000 * *detector.latency_s) : std::nullopt, 3));
        row = columns.cells(std::move(row), detector.arm);
      });
  std::vector<Cell> bound =
      columns.cells({"no delay at all", "no skin can do better", "0"}, results.undelayed);
  bound.back() = number_cell(arm.highest_speed_m_s(), 3);  // no estimate, but v = sqrt(2 a F / k)
  section.rows.push_back(std::move(bound));
  return section;
}

/// A table as a CSV file: the column "median delay (ms)" is called "median_delay_ms".
TableSection named_for_programs(TableSection table) {
  for (Column& column : table.columns) {
    std::string name;
    for (const char c : column.title) {
      if (c == '(' || c == ')') continue;
      if (c == '%') {
        name += "percent";
      } else {
        name += c == ' ' || c == '/' ? '_' : c;
      }
    }
    column.title = name;
  }
  return table;
}

/// The CSV file of the runs: a line for each detector and run.
TableSection run_data(const CollisionResults& results) {
  TableSection section;
  section.columns = columns_named(
      "detector alarm_by run speed_m_s onset_s delay_s delay_latency_s peak_N needless_stop done");
  for (const Detector& detector : results.detectors) {
    for (std::size_t r = 0; r < detector.arm.runs.size(); ++r) {
      const ArmRun& run = detector.arm.runs[r];
      section.rows.push_back(
          {detector.label, name_of(detector.rule), std::to_string(r),
           exact_cell(run.truth.speed_m_s), exact_cell(run.truth.onset_s), exact_cell(run.delay_s),
           run.delay_s ? exact_cell(run.of_latency_s) : Cell(), exact_cell(run.peak_N),
           run.needless_stop ? "1" : "0", run.done ? "1" : "0"});
    }
  }
  return section;
}

}  // namespace

json collision_json(const CollisionResults& results) {
  json out = {{"condition", results.condition},
              {"false_alarms_asked_per_hour", results.per_hour},
              {"calibration_hours", results.calibration_hours},
              {"frame_rate", results.frame_rate},
              {"stiffness_N_mm", results.arm.stiffness_N_mm},
              {"deceleration_m_s2", results.arm.deceleration_m_s2},
              {"aim_N", results.arm.aim_N},
              {"limit_N", results.arm.limit_N},
              {"highest_speed_without_delay_m_s", results.arm.highest_speed_m_s()},
              {"without_delay", arm_columns(results.arm).json(results.undelayed)}};
  for (std::size_t r = 0; r < results.region_areas.size(); ++r) {
    out["region_areas"][roman(static_cast<int>(r))] = results.region_areas[r];
  }
  out["detectors"] = json::array();
  for (const Detector& detector : results.detectors) {
    out["detectors"].push_back(detector_json(detector, results.arm));
  }
  return out;
}

void add_collision_tables(const CollisionResults& results, StudySection& section) {
  const std::vector<TableSection>& tables =
      section.report.tables = {quiet_table(results), threshold_table(results),
                               least_force_table(results), arm_runs_table(results)};
  section.data = {{"_alarms", named_for_programs(tables[0])},
                  {"_thresholds", named_for_programs(tables[1])},
                  {"_least_force", named_for_programs(tables[2])},
                  {"_arm", named_for_programs(tables[3])},
                  {"_runs", run_data(results)}};
}

}  // namespace ertbench
