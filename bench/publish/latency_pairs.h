#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/record/result_row.h"
#include "bench/table/table.h"
#include "core/interval.h"

namespace ertbench {

/// A row that was timed, and on what.
struct TimedRow {
  std::string result;  ///< folder of the result below results/published
  ResultRow row;
  std::string cpu;
  /// "commit 0123456789ab, program 01234567"; of results that do not say it the commit alone.
  std::string build;
};

/// Two results' times of one solver with the same settings.
struct LatencyPair {
  TimedRow first;
  TimedRow second;
  bool agree = false;  ///< whether their intervals meet, in µs or in units of the calibration loop
  std::string reason;  ///< why they may differ where they do: machine, build; empty: there is none
};

/// The interval of a row's p50: from the least to the greatest of its rounds, µs.
Interval latency_interval(const ResultRow& row);

/// What a frame's time depends on, in canonical JSON: the type and the settings, without those of
/// the training and of the regularisation. Of a solver that iterates, which stops by its
/// "tolerance", all settings and the test set.
std::string timed_settings(const ResultRow& row);

/// The timed rows of every result below a folder.
std::vector<TimedRow> timed_rows(const std::filesystem::path& published);

/// All pairs of rows of different results with the same timed_settings.
std::vector<LatencyPair> latency_pairs(const std::vector<TimedRow>& rows);

/// The pairs for people: who, where, p50 with intervals, whether they agree and if not, why.
Table latency_table(const std::vector<LatencyPair>& pairs);

}  // namespace ertbench
