#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
#include "bench/report/report.h"
#include "bench/report/result_table.h"

namespace ertbench {

/// What the page has beside the rows, their tables and charts.
struct BesideRows {
  std::vector<ReportFigure> training_curves;
  std::vector<ReportSection> sections;
  std::vector<std::string> undrawn;  ///< figures that could not be drawn
};

/// Writes what is made of rows alone: table.md, table.csv, table.tex, the experiment's charts, and
/// with what there is beside them report.html and summary.json. `summary` has all but the rows and
/// what follows from them. Returns how many figures could not be drawn.
std::size_t write_rows(const Experiment& experiment, const std::vector<ResultRow>& rows,
                       const TableText& text, BesideRows beside, nlohmann::json summary,
                       const std::filesystem::path& folder);

/// summary.json, table.md, table.csv, table.tex, differences.md, differences.csv, the figure of
/// reconstructions, the charts that the experiment asks for, those of the training, and report.html
/// of all this; each file is written aside and renamed. A figure that cannot be drawn holds up
/// nothing: its file says why, and summary.json names it under "undrawn". Returns how many there
/// are.
///
/// `sections`: what the stages add to the page.
std::size_t write_results(const Experiment& experiment, const Cache& cache,
                          const ExperimentResults& results,
                          const std::vector<ReportSection>& sections,
                          const std::filesystem::path& folder);

/// A dataset in a sentence, for the tables' legends.
std::string description(const DatasetSpec& spec);

/// The page of an experiment whose charts have been drawn into `folder`: a table for each test set
/// and how to read it, the sections of the ladders, the charts, the reconstructions where there are
/// any, the training curves and where the numbers come from.
Report report_of(const Experiment& experiment, const std::vector<ResultRow>& rows,
                 const TableText& text, const std::vector<ReportFigure>& training_curves,
                 const std::vector<ReportSection>& ladders, const nlohmann::json& provenance,
                 const std::filesystem::path& folder);

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
