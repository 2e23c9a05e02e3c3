#include "bench/table/table.h"

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "core/text.h"

namespace ertbench {

Cell number_cell(const std::optional<double>& value, int decimals) {
  Cell cell(value ? fixed(*value, decimals) : "—");
  cell.value = value;
  return cell;
}

Cell exact_cell(const std::optional<double>& value) {
  Cell cell;
  if (!value || !std::isfinite(*value)) return cell;
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.begin(), buffer.end(), *value);
  cell.text.assign(buffer.begin(), end.ptr);
  cell.value = value;
  return cell;
}

std::string interval_text(const std::string& low, const std::string& high) {
  return "[" + low + ", " + high + "]";
}

void TableSection::require_cells() const {
  for (const std::vector<Cell>& row : rows) {
    if (row.empty() || row.size() != columns.size()) {
      throw std::invalid_argument("table: " + caption + ": a cell for each column");
    }
  }
}

}  // namespace ertbench
