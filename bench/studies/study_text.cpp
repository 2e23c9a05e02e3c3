#include "bench/studies/study_text.h"

#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/text.h"

namespace ertbench {

std::string force_text(const std::pair<double, double>& force_N) {
  const std::string low = number_text(force_N.first);
  return (force_N.first == force_N.second ? low : low + " to " + number_text(force_N.second)) +
         " N";
}

std::string noise_text(const Noise& noise) {
  if (!noise.snr_db) return "no noise";
  return number_text(*noise.snr_db) + " dB " + name_of(noise.basis);
}

std::string without_law(const std::string& title) {
  for (const std::string end : {", rising law", ", falling law"}) {
    if (title.ends_with(end)) return title.substr(0, title.size() - end.size());
  }
  return title;
}

void write_study_tables(const Table& table, const TableSection& rows,
                        const std::filesystem::path& folder, const std::string& name) {
  write_file_atomically(folder / (name + ".md"), markdown_of(table));
  write_file_atomically(folder / (name + ".csv"), csv_of(rows));
}

std::vector<Cell> exact_cells(const std::optional<Estimate>& estimate) {
  if (!estimate) return std::vector<Cell>(3);
  return {exact_cell(estimate->value), exact_cell(estimate->ci95.low),
          exact_cell(estimate->ci95.high)};
}

std::vector<Column> exact_columns(const std::string& name) {
  return {name, name + "_low", name + "_high"};
}

}  // namespace ertbench
