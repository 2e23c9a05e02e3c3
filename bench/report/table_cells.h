#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/report/table.h"

/// What the Markdown and the LaTeX table have in common: the cells as lines of plain UTF-8 text, to
/// be escaped by whoever prints them.
namespace ertbench {

using Cell = std::vector<std::string>;

struct CellTable {
  std::string dataset;
  Cell head;                            ///< one line for each column
  std::vector<std::vector<Cell>> rows;  ///< [row][column]
  std::string description;  ///< of the test set: what it holds, frames, RES of the truth
  Cell notes;               ///< messages too long for their row
};

/// Columns up to this one are the label and the paper's metrics.
inline constexpr std::size_t kPublishedColumns = 1 + kPublishedMetrics.size();

/// One table for each dataset, in the order of their first rows.
std::vector<CellTable> cell_tables(std::span<const ResultRow> rows, const TableText& text);

/// One entry a column or rule of reading, for under the tables of these rows.
std::vector<std::string> legend(std::span<const ResultRow> rows, const TableText& text);

std::optional<double> published_value(const PublishedTable& published, const ResultRow& row,
                                      Metric metric);

}  // namespace ertbench
