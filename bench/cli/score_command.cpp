#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/cli/command.h"
#include "bench/run/score_images.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "core/output_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

struct ScoreArguments {
  std::string images;
  std::string truth;
  std::string sensor;
  std::string dataset;
  std::string json;
};

bool holds_scores(const std::filesystem::path& file) {
  try {
    const nlohmann::json content = read_json_file(file);
    return content.is_object() && content.contains("metrics") && content.contains("schema");
  } catch (const InputError&) {
    return false;
  }
}

Table table_of(const ImageScores& scores) {
  TableSection section;
  section.columns = {Column("metric", Align::left),
                     Column("mean"),
                     Column("95 %"),
                     Column("median"),
                     Column("frames"),
                     Column("undefined")};
  for (const Metric metric : kMetrics) {
    const MetricSummary& summary = scores.metrics[metric];
    const int decimals = decimals_of(metric);
    const std::string interval = summary.ci95 ? interval_text(fixed(summary.ci95->low, decimals),
                                                              fixed(summary.ci95->high, decimals))
                                              : "—";
    section.rows.push_back({Cell(entry_of(metric).heading), number_cell(summary.mean, decimals),
                            Cell(interval), number_cell(summary.median, decimals),
                            Cell(std::to_string(summary.count)),
                            Cell(std::to_string(summary.undefined))});
  }
  section.notes.push_back(std::to_string(scores.frames) + " frames, " +
                          std::to_string(scores.undefined_frames) +
                          " without a usable image; true contacts: " + scores.contacts +
                          ". `ertbench list` says what the metrics are.");
  Table table;
  table.sections.push_back(std::move(section));
  return table;
}

ExitCode score(const ScoreArguments& arguments) {
  if (!arguments.json.empty()) {
    require_output(arguments.json, {arguments.images, arguments.truth}, {"scores", holds_scores});
  }
  const ImageScores scores =
      score_images({arguments.images, arguments.truth, arguments.sensor, arguments.dataset});
  if (!arguments.json.empty()) {
    write_file_atomically(arguments.json, json_text(to_json(scores), 1) + "\n");
  }
  std::printf("%s", terminal_of(table_of(scores)).c_str());
  return done;
}

}  // namespace

Action add_score(CLI::App& command) {
  const auto arguments = std::make_shared<ScoreArguments>();
  command.description("All metrics of images that were made elsewhere");
  command
      .add_option("IMAGES", arguments->images,
                  "HDF5 with /conductivity_change (or /conductivity) [N, rows, columns] S/m, and\n"
                  "/status [N] where it is there (2: undefined)")
      ->required();
  command
      .add_option("TRUTH", arguments->truth,
                  "A dataset file, or HDF5 with /conductivity [N, rows, columns] S/m")
      ->required();
  command.add_option("--sensor", arguments->sensor,
                     "JSON of the sensor (default: what the files say, else EIDORS's d2s)");
  command.add_option("--dataset", arguments->dataset, "Dataset of the images in their file");
  command.add_option("--json", arguments->json, "Also write the table as JSON");
  command.footer(
      "Example:\n  ertbench reconstruct --solver gn.json --input test.h5 --output images.h5\n"
      "  ertbench score images.h5 test.h5 --json scores.json\n"
      "See docs/own_frames.md.");
  return [arguments] { return score(*arguments); };
}

}  // namespace ertbench
