#include "bench/studies/collision.h"
#include "bench/studies/error_statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

Cell percent_cell(const CountedShare& share) {
  const auto estimate = share.share();
  if (!estimate) return "—";
  Cell cell = number_cell(100 * estimate->value, 1);
  cell.interval =
      interval_text(fixed(100 * estimate->ci95.low, 1), fixed(100 * estimate->ci95.high, 1));
  cell.lines = {std::to_string(share.count) + " of " + std::to_string(share.total)};
  return cell;
}

Cell scaled_cell(std::optional<Estimate> estimate, double scale, int decimals) {
  if (estimate) {
    estimate->value *= scale;
    estimate->ci95 = {estimate->ci95.low * scale, estimate->ci95.high * scale};
  }
  return estimate_cell(estimate, decimals);
}

Cell three_digits_cell(double value, const Interval& ci95) {
  Cell cell(three_digits(value));
  cell.value = value;
  cell.interval = interval_text(three_digits(ci95.low), three_digits(ci95.high));
  return cell;
}

/// A least force, N.
Cell least_force_cell(const std::optional<LeastFound>& found) {
  if (!found) return "—";
  const auto text = [&](double force_N) {
    if (force_N > found->reach.high) return "> " + fixed(found->reach.high, 2);
    if (force_N <= found->reach.low) return "≤ " + fixed(found->reach.low, 2);
    return fixed(force_N, 2);
  };
  Cell cell(text(found->value));
  if (found->value <= found->reach.high) cell.value = found->value;
  cell.interval = interval_text(text(found->ci95.low), text(found->ci95.high));
  return cell;
}

/// A highest speed, m/s.
Cell highest_speed_cell(const std::optional<LeastFound>& found) {
  if (!found) return "—";
  const auto text = [&](double speed_m_s) {
    if (speed_m_s < found->reach.low) return "< " + fixed(found->reach.low, 3);
    if (speed_m_s >= found->reach.high) return "≥ " + fixed(found->reach.high, 3);
    return fixed(speed_m_s, 3);
  };
  Cell cell(text(found->value));
  if (found->value >= found->reach.low) cell.value = found->value;
  cell.interval = interval_text(text(found->ci95.low), text(found->ci95.high));
  return cell;
}

Cell delay_cell(const std::optional<Estimate>& delay_s) {
  if (!delay_s) return "—";
  const auto text = [](double seconds) {
    return seconds < ArmOutcome::never_s ? fixed(1000 * seconds, 1) : std::string("never");
  };
  Cell cell(text(delay_s->value));
  if (delay_s->value < ArmOutcome::never_s) cell.value = 1000 * delay_s->value;
  cell.interval = interval_text(text(delay_s->ci95.low), text(delay_s->ci95.high));
  return cell;
}

Cell peak_cell(const std::optional<Estimate>& peak_N, double limit_N) {
  if (!peak_N) return "—";
  const auto text = [&](double force_N) {
    return (force_N < limit_N ? "" : "≥ ") + fixed(force_N, 1);
  };
  Cell cell(text(peak_N->value));
  cell.value = peak_N->value;
  cell.interval = interval_text(text(peak_N->ci95.low), text(peak_N->ci95.high));
  return cell;
}

/// A row of the detector: its names, then what `fill` adds, or why there is nothing.
template <typename Fill>
void add_detector_row(const Detector& detector, TableSection& section, const Fill& fill) {
  const std::string rule = detector.rule == AlarmRule::voltage_norm ? "one threshold, no solver"
                                                                    : name_of(detector.rule);
  std::vector<Cell> row = {detector.label, rule};
  if (detector.failure.empty()) {
    fill(row);
  } else {
    row.front().lines = {detector.failure};
  }
  while (row.size() < section.columns.size()) row.emplace_back("—");
  section.rows.push_back(std::move(row));
}

std::vector<Column> detector_columns(const std::vector<std::string>& titles) {
  std::vector<Column> columns = {{"detector", Align::left}, {"alarm by", Align::left}};
  for (const std::string& title : titles) columns.emplace_back(title);
  return columns;
}

TableSection quiet_table(const CollisionResults& results) {
  TableSection section;
  double hours = 0;
  for (const Detector& detector : results.detectors) hours = std::max(hours, detector.quiet.hours);
  section.caption = "False alarms where nothing touches: " + results.condition + "; " +
                    number_text(results.per_hour) + " an hour asked for, thresholds set on " +
                    three_digits(results.calibration_hours) + " h, tried on other " +
                    three_digits(hours) + " h";
  section.columns = detector_columns({"alarms", "an hour", "quiet time in alarm (%)"});
  for (const Detector& detector : results.detectors) {
    add_detector_row(detector, section, [&](std::vector<Cell>& row) {
      row.emplace_back(std::to_string(detector.quiet.alarms));
      row.push_back(three_digits_cell(detector.quiet.per_hour(), detector.quiet.ci95()));
      row.push_back(scaled_cell(detector.quiet_alarmed, 100, 3));
    });
  }
  return section;
}

std::vector<std::string> region_titles(const CollisionResults& results) {
  std::vector<std::string> titles = {"whole sheet"};
  for (std::size_t r = 0; r < results.region_areas.size(); ++r) {
    titles.push_back(roman(static_cast<int>(r)));
  }
  return titles;
}

TableSection threshold_table(const CollisionResults& results) {
  TableSection section;
  section.caption = "Thresholds: " + results.condition +
                    "; largest |δσ| in mS/m by region, norm of the voltage change in mV";
  section.columns = detector_columns(region_titles(results));
  for (const Detector& detector : results.detectors) {
    add_detector_row(detector, section, [&](std::vector<Cell>& row) {
      if (detector.rule == AlarmRule::by_region) row.emplace_back("—");
      for (const AlarmThreshold& threshold : detector.thresholds) {
        row.push_back(three_digits_cell(1000 * threshold.value,
                                        {1000 * threshold.ci95.low, 1000 * threshold.ci95.high}));
        if (threshold.borrowed) row.back().lines = {"of the whole sheet"};
      }
    });
  }
  return section;
}

TableSection least_force_table(const CollisionResults& results) {
  TableSection section;
  section.caption = "Least force that is found in 95 % of the presses, N: " + results.condition;
  section.columns = detector_columns(region_titles(results));
  section.columns.emplace_back("undefined frames");
  for (const Detector& detector : results.detectors) {
    add_detector_row(detector, section, [&](std::vector<Cell>& row) {
      row.push_back(least_force_cell(detector.least_N));
      for (const auto& least_N : detector.least_by_region_N) {
        row.push_back(least_force_cell(least_N));
      }
      row.emplace_back(std::to_string(detector.undefined_presses));
    });
  }
  return section;
}

void add_arm_cells(const ArmOutcome& arm, const ArmSettings& settings, std::vector<Cell>& row) {
  row.push_back(delay_cell(arm.median_delay_s));
  row.push_back(delay_cell(arm.p95_delay_s));
  row.push_back(scaled_cell(arm.latency_share, 100, 1));
  row.push_back(peak_cell(arm.median_peak_N, settings.limit_N));
  row.push_back(peak_cell(arm.p95_peak_N, settings.limit_N));
  row.push_back(percent_cell(arm.under_aim));
  row.push_back(percent_cell(arm.under_limit));
  row.push_back(percent_cell(arm.done));
  row.push_back(scaled_cell(arm.mean_lost_s, 1, 2));
  row.push_back(percent_cell(arm.needless));
  row.push_back(highest_speed_cell(arm.highest_speed_m_s));
}

TableSection arm_runs_table(const CollisionResults& results) {
  const ArmSettings& arm = results.arm;
  TableSection section;
  section.caption = "An arm runs into an obstacle: " + results.condition + "; " +
                    number_text(results.frame_rate) + " frames a second, " +
                    number_text(arm.stiffness_N_mm) + " N/mm, " +
                    number_text(arm.deceleration_m_s2) + " m/s²";
  section.columns = detector_columns(
      {"latency (ms)", "median delay (ms)", "95 % delay (ms)", "of it latency (%)",
       "median peak (N)", "95 % peak (N)", "under " + number_text(arm.aim_N) + " N (%)",
       "under " + number_text(arm.limit_N) + " N (%)", "tasks done (%)", "time lost (s)",
       "needless stops (%)", "highest speed (m/s)"});
  for (std::size_t c = 6; c < section.columns.size(); ++c) section.columns[c].part = c < 9 ? 1 : 2;
  for (const Detector& detector : results.detectors) {
    add_detector_row(detector, section, [&](std::vector<Cell>& row) {
      row.push_back(number_cell(
          detector.latency_s ? std::optional(1000 * *detector.latency_s) : std::nullopt, 3));
      add_arm_cells(detector.arm, arm, row);
    });
  }
  std::vector<Cell> bound = {"no delay at all", "no skin can do better", "0"};
  add_arm_cells(results.undelayed, arm, bound);
  bound.back() = number_cell(arm.highest_speed_m_s(), 3);  // no estimate, but v = sqrt(2 a F / k)
  section.rows.push_back(std::move(bound));
  return section;
}

}  // namespace

std::string collision_text(const CollisionResults& results) {
  return "An image raises an alarm when its largest |δσ| reaches a threshold: one for the whole "
         "sheet, or that of the region (of the symmetry orbits of 5 × 5 areas, I the corners to VI "
         "the centre) in which the strongest contact lies. Thresholds are set on frames in which "
         "nothing touches, so that " +
         number_text(results.per_hour) +
         " alarms an hour are false, each region having a share in proportion to its area. So rare "
         "a value lies beyond what was seen: the excesses of peaks over a high level are taken to "
         "be exponential and extrapolated. For comparison stands an alarm by the 2-norm of the "
         "voltages' change, which needs no image.\n\nThe arm goes on at its speed until the alarm "
         "and then decelerates; the force on the obstacle grows with the way. The delay counts "
         "from the first touch to the end of the solver's work on the frame that raised the alarm; "
         "a solver that is slower than the frames takes the newest and drops the others.";
}

std::vector<std::string> collision_notes(const CollisionResults& results) {
  return {
      "Intervals are 95 %: of thresholds by the bootstrap over blocks of frames, of counts exact "
      "Poisson intervals, of shares Wilson's, else by the bootstrap over scenes or sequences. A "
      "Poisson interval takes alarms to be independent, which under drift they are not.",
      "Alarm frames that follow each other are one alarm; \"quiet time in alarm\" shows where such "
      "an alarm does not end.",
      "\"of the whole sheet\": fewer than 30 of the calibration frames have their largest value in "
      "that region, which takes the threshold of the whole sheet.",
      "Least force: where the isotonic fit of detection against force reaches 95 %. \"> x\": not "
      "at the largest force pressed; \"≤ x\": at the twenty lightest presses already; a dash: "
      "fewer than forty presses.",
      "Runs in which an alarm came before anything touched are needless stops; they count against "
      "the tasks done and stand in no delay, no force and no speed. A run without an alarm has an "
      "endless delay, and the limit (" +
          number_text(results.arm.limit_N) + " N) or more for its force.",
      "Time lost: by the runs that stopped, in decelerating, retreating to " +
          number_text(results.arm.clearance_mm) + " mm from the obstacle and passing " +
          number_text(results.arm.aside_mm) + " mm aside, over going straight on.",
      "Of it latency: what a solver that takes no time would save of the delays, waiting for its "
      "turn included. Where the latency has a dash it was not measured and counts as 0.",
      "Highest speed: up to which 95 % of the runs stay under " + number_text(results.arm.aim_N) +
          " N. Without any delay the way v²/2a alone allows " +
          fixed(results.arm.highest_speed_m_s(), 3) +
          " m/s. \"< x\": not even the slowest runs do; a "
          "dash: fewer than forty runs."};
}

std::vector<TableSection> collision_tables(const CollisionResults& results) {
  return {quiet_table(results), threshold_table(results), least_force_table(results),
          arm_runs_table(results)};
}

}  // namespace ertbench
