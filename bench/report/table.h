#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/published_table.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// What stands around the numbers.
struct TableText {
  std::string title;                                        ///< the experiment's name
  std::map<std::string, std::string> dataset_descriptions;  ///< by the dataset's name; may lack any
  std::string command;                                      ///< makes the table again
  PublishedTable published;
};

/// The rows as tables for people: one for each test set, in the order of their first rows, and a
/// legend. The paper's metrics show the mean, its 95 % interval, the published value and the
/// difference of the two; what is undefined is a dash with the number of frames. A row that failed
/// stays, with its status and message; a long message is cut there and stands whole below the
/// table. Rows of several seeds show the spread of the seeds' means too.
std::string markdown_table(std::span<const ResultRow> rows, const TableText& text);

/// The same for LaTeX: `table` floats to \input into any document class. Needs no package; two
/// tabulars a test set, so that it fits the width of a page.
std::string latex_table(std::span<const ResultRow> rows, const TableText& text);

/// One line a row, every number in a column of its own and with all its digits (RFC 4180 quoting,
/// UTF-8, lines end in \n): for each metric `AR_mean,AR_low,AR_high,AR_median,AR_median_low,
/// AR_median_high,AR_count,AR_undefined,AR_seed_deviation`, for the published four
/// `AR_paper,AR_difference` as well. What is undefined is an empty field.
std::string csv_table(std::span<const ResultRow> rows, const PublishedTable& published);

}  // namespace ertbench
