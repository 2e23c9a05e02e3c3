#include "bench/table/writers.h"
#include "core/csv_field.h"
#include "core/text.h"

namespace ertbench {

std::string csv_of(const TableSection& section) {
  section.require_cells();
  std::string out;
  for (std::size_t c = 0; c < section.columns.size(); ++c) {
    out += (c > 0 ? "," : "") + csv_field(printable_lines(section.columns[c].title));
  }
  out += "\n";
  for (const auto& row : section.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string text =
          row[c].value ? exact_cell(row[c].value).text : printable_lines(row[c].text);
      out += (c > 0 ? "," : "") + csv_field(text);
    }
    out += "\n";
  }
  return out;
}

}  // namespace ertbench
