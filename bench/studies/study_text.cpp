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

void write_study_tables(const Table& table, const std::filesystem::path& folder,
                        const std::string& name) {
  write_file_atomically(folder / (name + ".md"), markdown_of(table));
  for (std::size_t s = 0; s < table.sections.size(); ++s) {
    const std::string number = table.sections.size() > 1 ? "_" + std::to_string(s + 1) : "";
    write_file_atomically(folder / (name + number + ".csv"), csv_of(table.sections[s]));
  }
}

}  // namespace ertbench
