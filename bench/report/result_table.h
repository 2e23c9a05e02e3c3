#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

/// The paper's value for this row, where it is compared on the row's test set.
std::optional<double> published_value(const PublishedTable& published, const ResultRow& row,
                                      Metric metric);

// Remarks on rows that a reader must not overlook although the status is ok.

/// Whether the mean relative error of the row's images is larger than that of the image without a
/// contact on the same test set: whoever shows nothing does better.
bool worse_than_no_contact(const ResultRow& row, std::span<const ResultRow> rows);

/// The processor on which most of the rows were timed, the first of several; empty where none says.
std::string usual_processor(std::span<const ResultRow> rows);

/// Whether the row's times are of another processor than `usual` (usual_processor): two clocks that
/// must not be compared.
bool timed_elsewhere(const ResultRow& row, const std::string& usual);

/// Sentences for the foot of a table: which rows were timed on other processors, and which while
/// other processes kept the machine busy. None where there is nothing to say.
std::vector<std::string> timing_remarks(std::span<const ResultRow> rows);

}  // namespace ertbench
