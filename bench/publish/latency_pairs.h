#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/record/result_row.h"
#include "bench/table/table.h"
#include "core/statistics.h"

namespace ertbench {

/// What one result has measured of one solver's time, and on what: the rows of all its test sets
/// whose timed_settings are the same.
struct TimedSolver {
  std::string result;  ///< folder of the result below results/published
  std::string label;   ///< of its first row
  std::string settings;
  std::vector<double> rounds_us;  ///< p50 of each round of each row
  /// The same in units of the calibration loop as it ran in each round (LatencySummary's
  /// relative_of_rounds); of rows without those, as it ran in the row's process. Empty unless all
  /// rows have one or the other.
  std::vector<double> rounds_in_units;
  std::string cpu;
  /// "commit 0123456789ab, program 01234567"; of results that do not say it the commit alone.
  std::string build;
  bool says_build = false;  ///< whether the rows themselves say which build timed them
  /// "Linux 6.1.0-18-amd64", by which machines of one processor's name may be told apart; empty
  /// where it is not known of the machine that took the times.
  std::string system = {};
};

/// Two results' times of one solver with the same settings.
struct LatencyPair {
  TimedSolver first;
  TimedSolver second;
  bool agree = false;  ///< whether their intervals meet or nearly so, in µs or in the calibration
                       ///< loop's units
  std::string
      reason;  ///< why they may differ where they do: machine, system, build; empty: there is none
};

/// From the least to the greatest of the rounds, µs. What a frame costs does not depend on what is
/// not in its timed_settings, so what differs between the rows of one result is the machine's
/// doing, and part of the interval.
Interval latency_interval(const TimedSolver& solver);

/// What a frame's time depends on, in canonical JSON: the type, the sensor's electrodes and pixels,
/// and the settings, without those of the training and of the regularisation. Of a solver whose
/// work is as much as the frame asks for (it iterates, adds contacts, leaves out components that
/// weigh nothing) all settings, and the frames: which of `test_sets` {name: description of the data
/// set} they are of, and how many.
std::string timed_settings(const ResultRow& row, const nlohmann::json& test_sets);

/// A result's rows, put together by their settings, in the order of their first rows. Rows without
/// a latency are left out. `provenance` is the result's: "cpu", "system", "commit", "datasets".
std::vector<TimedSolver> timed_solvers(const std::string& result, const nlohmann::json& provenance,
                                       const std::vector<ResultRow>& rows);
/// Those of every result below a folder.
std::vector<TimedSolver> timed_solvers(const std::filesystem::path& published);

/// All pairs of solvers of different results with the same settings.
std::vector<LatencyPair> latency_pairs(const std::vector<TimedSolver>& solvers);

/// The pairs for people: who, where, p50 with intervals, whether they agree and if not, why.
Table latency_table(const std::vector<LatencyPair>& pairs);

}  // namespace ertbench
