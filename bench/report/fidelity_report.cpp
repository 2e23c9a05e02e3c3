#include "bench/report/fidelity_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/charts/fidelity_chart.h"
#include "bench/plot/drawing.h"
#include "bench/record/provenance.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/json_text.h"
#include "core/text.h"

namespace ertbench {
namespace {

std::string digits(double value, const char* format = "%.4g") {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// For programs.
TableSection data_of(const std::vector<FidelityRow>& rows) {
  TableSection section;
  section.columns = {"dataset",
                     "scenes",
                     "model",
                     "count",
                     "time_us",
                     "time_p5_us",
                     "time_p95_us",
                     "error_median",
                     "error_p95",
                     "error_max",
                     "bound",
                     "within_bound",
                     "promised",
                     "promised_and_kept",
                     "estimate_over_error"};
  for (const int size : fidelity_sizes) {
    section.columns.emplace_back("points_to_" + std::to_string(size));
  }
  section.columns.emplace_back("points_more");
  for (const FidelityRow& row : rows) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells = {row.dataset,
             row.scenes,
             row.model,
             std::to_string(row.count),
             digits(row.time_us),
             digits(row.time_low),
             digits(row.time_high),
             digits(row.error_median),
             digits(row.error_p95),
             digits(row.error_max),
             digits(row.bound, "%g"),
             std::to_string(row.kept)};
    if (row.model == "auto") {
      cells.emplace_back(std::to_string(row.promised));
      cells.emplace_back(std::to_string(row.promised_kept));
      cells.emplace_back(digits(row.tightness, "%.3g"));
      for (const int count : row.sizes) cells.emplace_back(std::to_string(count));
    }
    cells.resize(section.columns.size());
  }
  return section;
}

/// For people.
TableSection models_section(const std::vector<FidelityRow>& rows) {
  TableSection section;
  section.caption = "The models";
  section.columns = {
      {"dataset", Align::left}, {"scenes", Align::left}, "number", {"model", Align::left}};
  for (const char* title : {"time (µs)", "scenes/s", "median error", "95 % of error", "largest",
                            "within the bound", "kept of promised", "estimate / error"}) {
    section.columns.emplace_back(title);
  }
  for (const FidelityRow& row : rows) {
    const bool automatic = row.model == "auto";
    Cell time = three_digits(row.time_us);
    time.interval = interval_text(three_digits(row.time_low), three_digits(row.time_high));
    section.rows.push_back(
        {row.dataset, row.scenes, std::to_string(row.count), row.model, time,
         three_digits(1e6 / row.time_us), three_digits(row.error_median),
         three_digits(row.error_p95), three_digits(row.error_max),
         fixed(100.0 * row.kept / row.count, 1) + " %",
         automatic ? std::to_string(row.promised_kept) + " of " + std::to_string(row.promised) : "",
         automatic ? three_digits(row.tightness) : ""});
  }
  return section;
}

Table table_of(const std::vector<FidelityRow>& rows, const Experiment& experiment) {
  Table table;
  table.title = experiment.title;
  table.text = experiment.question;
  table.sections = {models_section(rows)};
  table.legend = {
      "Errors are 2-norms over the channels in units of the frame's noise, against the border "
      "integral equation at a thousandth of the bound.",
      "Times are of one thread of " + cpu_name() + ", a scene: median of the blocks of " +
          std::to_string(fidelity_block) + ", 5 to 95 % in brackets.",
      "\"smooth\" are scenes of whole discs and ellipses apart from each other, \"other\" those "
      "with corners, overlaps or contacts cut by the border of the sheet; blank scenes are left "
      "out.",
      "\"kept of promised\": scenes whose error is within the bound, of those whose estimate is."};
  table.command = "./ertbench fidelity experiments/" + experiment.name + ".json";
  return table;
}

}  // namespace

void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const Builds& builds, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::vector<FidelityRow> rows;
  std::vector<std::string> failures;
  for (const FidelityOutcome& outcome : outcomes) {
    rows.insert(rows.end(), outcome.rows.begin(), outcome.rows.end());
    if (!outcome.failure.empty()) {
      failures.push_back("Not measured: " + outcome.dataset + ", " + outcome.failure + ".");
    }
  }
  Table table = table_of(rows, experiment);
  table.sections.front().notes = failures;
  if (!builds.empty()) table.legend.push_back(text_of(builds));
  nlohmann::json origin = provenance(experiment, 1, {});
  origin["builds"] = to_json(builds);
  write_file_atomically(folder / "fidelity.csv", csv_of(data_of(rows)));
  write_file_atomically(folder / "fidelity.md", markdown_of(table));
  write_file_atomically(folder / "provenance.json", json_text(origin, 2) + "\n");
  if (!rows.empty()) {
    draw_or_say(folder / "fidelity",
                [&] { draw_fidelity_chart(rows, experiment.title, folder / "fidelity"); });
  }
  std::printf("%s\nResults in %s\n", terminal_of(table).c_str(),
              printable_path(folder.string()).c_str());
}

}  // namespace ertbench
