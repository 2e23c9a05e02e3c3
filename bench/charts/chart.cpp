#include "bench/charts/chart.h"

#include <algorithm>

namespace ertbench {

std::string Chart::notes(std::span<const ResultRow> /*rows*/) const { return ""; }

std::vector<TableSection> Chart::tables(std::span<const ResultRow> /*rows*/) const { return {}; }

void Chart::summarise(std::span<const ResultRow> /*rows*/, nlohmann::json& /*summary*/) const {}

const ResultRow* Chart::find_row(std::span<const ResultRow> rows, const std::string& label) const {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const ResultRow& row) {
    return row.label == label && row.dataset == dataset();
  });
  return found == rows.end() ? nullptr : &*found;
}

std::string chart_status(const ResultRow* row) {
  if (!row) return "not run";
  return row->ok() ? "" : row->status;
}

}  // namespace ertbench
