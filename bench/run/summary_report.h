#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment_charts.h"

namespace ertbench {

/// What became of a report.
struct SummaryReport {
  std::size_t undrawn = 0;             ///< figures that could not be drawn
  std::vector<std::string> elsewhere;  ///< parts of the run's report that a summary does not hold
  std::string command;                 ///< makes all of it
};

/// Writes what write_results writes, as far as it is made of the summary.json in `results`: the
/// tables, the charts, report.html and summary.json, into the new or empty folder `out`. Throws
/// InputError for a summary that is missing or damaged, and for another `out`.
SummaryReport report_summary(const std::filesystem::path& results, const std::filesystem::path& out,
                             const ChartTypes& charts);

}  // namespace ertbench
