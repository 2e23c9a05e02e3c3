#include "bench/report/ladder_report.h"

#include <algorithm>
#include <cstdio>

#include "bench/analysis/detection.h"
#include "bench/charts/ladder_chart.h"
#include "bench/charts/ladder_figures.h"
#include "bench/plot/drawing.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"

namespace ertbench {

std::vector<ReportSection> write_ladder_results(const Experiment& experiment,
                                                const std::vector<LadderOutcome>& outcomes,
                                                const Builds& builds,
                                                const std::filesystem::path& folder) {
  if (!experiment.ladders) return {};
  const Ladders& ladders = *experiment.ladders;
  const std::vector<AxisBreakdown> breakdowns = breakdowns_of(ladders, outcomes);
  const std::string title = experiment.title + ": where it breaks";
  Table breakdown = breakdown_table(title, ladders, breakdowns);
  if (!builds.empty()) breakdown.legend.push_back(text_of(builds));
  write_file_atomically(folder / "breakdown.csv", csv_of(breakdown_data(breakdowns)));
  write_file_atomically(folder / "breakdown.md", markdown_of(breakdown));
  Table printed;
  printed.title = "Where it breaks:";
  printed.sections = breakdown.sections;
  std::printf("%s\n", terminal_of(printed).c_str());
  write_file_atomically(folder / "levels.csv", csv_of(levels_data(outcomes)));
  const std::vector<AxisDetection> detections = detections_of(outcomes);
  const Table detected =
      detection_table(experiment.title + ": does it say so?", ladders, detections);
  write_file_atomically(folder / "detection.csv", csv_of(detection_data(detections)));
  write_file_atomically(folder / "detection.md", markdown_of(detected));

  ReportSection table;
  table.title = "Where it breaks";
  table.text = "All levels are variants of the test set " + ladders.dataset +
               ", one condition made worse at a time; every solver sees the same frames. The same "
               "numbers are in breakdown.csv, every level in levels.csv.";
  if (const auto map = ladder_map_of(title, breakdowns)) {
    const bool drawn =
        draw_or_say(folder / "breakdown", [&] { draw_heat_map(*map, folder / "breakdown"); });
    table.figures.push_back({"Where each solver breaks down", folder / "breakdown.svg",
                             "dark: early on the ladder; light: late or never", drawn});
  }
  table.tables = breakdown.sections;
  table.notes = breakdown.legend;

  ReportSection detection;
  detection.title = "Does it say so?";
  detection.text =
      "Of the frames that fail, how many the solver itself reports as suspect, not converged or "
      "undefined; and of those that do not fail, how many it reports so all the same. The same "
      "numbers are in detection.csv.";
  detection.tables = detected.sections;
  detection.notes = detected.legend;

  ReportSection charts;
  charts.title = "Failures and errors over the level";
  for (const LadderAxis& axis : ladders.axes) {
    const bool climbed = std::any_of(outcomes.begin(), outcomes.end(), [&](const auto& outcome) {
      return outcome.record && outcome.record->find(axis.name);
    });
    if (!climbed) continue;
    const std::string name = "ladder_" + axis.name;
    const bool drawn = draw_or_say(
        folder / name, [&] { draw_ladder_chart(ladders, axis, outcomes, folder / name); });
    charts.figures.push_back({axis.title, folder / (name + ".svg"),
                              "failing frames and relative error, mildest level on the left",
                              drawn});
  }
  std::vector<ReportSection> sections = {table, detection};
  if (!charts.figures.empty()) sections.push_back(charts);

  bool any = true;
  const bool drawn = draw_or_say(folder / "worst_frames", [&] {
    any = draw_gallery(ladders, outcomes, experiment.sensor, folder / "worst_frames");
  });
  if (any) {
    ReportSection gallery;
    gallery.title = "Worst frames";
    gallery.figures = {{"What failure looks like", folder / "worst_frames.svg",
                        "of each kind of failure the worst frame at the level where the solver "
                        "breaks down",
                        drawn}};
    sections.push_back(gallery);
  }
  return sections;
}

}  // namespace ertbench
