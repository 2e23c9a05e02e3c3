#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"

namespace ertbench {

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
