#pragma once

#include <map>
#include <span>
#include <string>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "bench/table/table.h"

namespace ertbench {

/// Texts around the numbers.
struct TableText {
  std::string title;                                        ///< the experiment's name
  std::map<std::string, std::string> dataset_descriptions;  ///< by the dataset's name; may lack any
  std::string command;                                      ///< makes the table again
  PublishedTable published;
  Builds builds;
};

/// The rows as a table for people: a section for each test set, in the order of their first rows,
/// and a legend. The paper's metrics show the mean, its 95 % interval, the published value and the
/// difference of the two; what is undefined is a dash with the number of frames. A row that failed
/// stays, with its status and message; a long message is cut there and stands whole below the
/// rows. Rows of several seeds show the spread of the seeds' means too. The legend names the rows
/// whose training had not converged (Convergence).
Table result_table(std::span<const ResultRow> rows, const TableText& text);

/// Returns a shorter table for the terminal.
Table result_summary(std::span<const ResultRow> rows);

/// The rows for programs: every number in a column of its own and with all its digits: for each
/// metric `AR_mean,AR_low,AR_high,AR_median,AR_median_low,AR_median_high,AR_count,AR_undefined,
/// AR_seed_deviation`, for the published ones `AR_paper,AR_difference` as well. What is undefined
/// is empty.
TableSection result_data(std::span<const ResultRow> rows, const PublishedTable& published);

}  // namespace ertbench
