#include "bench/report/fidelity_report.h"

#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/charts/fidelity_chart.h"
#include "bench/record/provenance.h"
#include "bench/table/text_table.h"
#include "core/atomic_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

std::string csv_of(const std::vector<FidelityRow>& rows) {
  std::string out =
      "dataset,scenes,model,count,time_us,time_p5_us,time_p95_us,error_median,error_p95,error_max,"
      "bound,within_bound,promised,promised_and_kept,estimate_over_error";
  for (const int size : fidelity_sizes) out += ",points_to_" + std::to_string(size);
  out += ",points_more\n";
  for (const FidelityRow& row : rows) {
    char line[400];
    std::snprintf(line, sizeof line, "%s,%s,%s,%d,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%g,%d",
                  row.dataset.c_str(), row.scenes.c_str(), row.model.c_str(), row.count,
                  row.time_us, row.time_low, row.time_high, row.error_median, row.error_p95,
                  row.error_max, row.bound, row.kept);
    out += line;
    if (row.model == "auto") {
      std::snprintf(line, sizeof line, ",%d,%d,%.3g", row.promised, row.promised_kept,
                    row.tightness);
      out += line;
      for (const int count : row.sizes) out += "," + std::to_string(count);
    } else {
      out += std::string(4 + std::size(fidelity_sizes), ',');
    }
    out += "\n";
  }
  return out;
}

std::string markdown_of(const std::vector<FidelityRow>& rows, const Experiment& experiment) {
  TextTable table;
  table.caption = "The models";
  table.header = {"dataset",   "scenes",           "number",           "model",
                  "time (µs)", "scenes/s",         "median error",     "95 % of error",
                  "largest",   "within the bound", "kept of promised", "estimate / error"};
  for (const FidelityRow& row : rows) {
    const bool automatic = row.model == "auto";
    table.rows.push_back(
        {row.dataset, row.scenes, std::to_string(row.count), row.model,
         three_digits(row.time_us) + " (" + three_digits(row.time_low) + " to " +
             three_digits(row.time_high) + ")",
         three_digits(1e6 / row.time_us), three_digits(row.error_median),
         three_digits(row.error_p95), three_digits(row.error_max),
         fixed(100.0 * row.kept / row.count, 1) + " %",
         automatic ? std::to_string(row.promised_kept) + " of " + std::to_string(row.promised) : "",
         automatic ? three_digits(row.tightness) : ""});
  }
  return "# " + experiment.title + "\n\n" + experiment.question + "\n\n" +
         ertbench::markdown_of(table) +
         "\nErrors are 2-norms over the channels in units of the frame's noise, against the border "
         "integral equation at a thousandth of the bound. Times are of one thread, a scene: median "
         "of the blocks of " +
         std::to_string(fidelity_block) +
         ", 5 to 95 % in brackets. \"smooth\" are "
         "scenes of whole discs and ellipses apart from each other, \"other\" those with corners, "
         "overlaps or contacts cut by the border of the sheet; blank scenes are left out. \"kept "
         "of "
         "promised\": scenes whose error is within the bound, of those whose estimate is.\n\nMade "
         "by "
         "`./ertbench fidelity experiments/" +
         experiment.name + ".json` on " + cpu_name() + ".\n";
}

}  // namespace

void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::vector<FidelityRow> rows;
  std::string failures;
  for (const FidelityOutcome& outcome : outcomes) {
    rows.insert(rows.end(), outcome.rows.begin(), outcome.rows.end());
    if (!outcome.failure.empty()) {
      failures += "\nNot measured: " + outcome.dataset + ", " + outcome.failure + ".\n";
    }
  }
  const std::string markdown = markdown_of(rows, experiment) + failures;
  write_file_atomically(folder / "fidelity.csv", csv_of(rows));
  write_file_atomically(folder / "fidelity.md", markdown);
  write_file_atomically(folder / "provenance.json", provenance(experiment, 1).dump(2) + "\n");
  if (!rows.empty()) draw_fidelity_chart(rows, experiment.title, folder / "fidelity");
  std::printf("%s\nResults in %s\n", markdown.c_str(), folder.c_str());
}

}  // namespace ertbench
