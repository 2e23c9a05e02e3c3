#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/cli/command.h"
#include "bench/table/table.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "frames/reconstruct.h"
#include "frames/score_images.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct CalibrateArguments {
  std::string output;
  bool fix = false;
  bool force = false;
  OwnFramesOptions frames;
};

ExitCode calibrate(const CalibrateArguments& arguments) {
  const CalibrationOutcome outcome =
      calibrate_file(arguments.frames, arguments.output, arguments.fix, arguments.force);
  const Calibration& c = outcome.calibration;
  std::printf("%s\n", printable_lines(outcome.verdict.text()).c_str());
  std::printf("%d frames\n", c.frames);
  std::printf("  noise               %s dB (absolute), %s dB of it from frame to frame alone\n",
              fixed(c.snr_absolute, 1).c_str(), fixed(c.snr_white, 1).c_str());
  std::printf("  noise of a channel  %.2g V (rms), %.2g V of the noisiest\n",
              std::sqrt(c.noise.squaredNorm() / static_cast<double>(c.noise.size())),
              c.noise.maxCoeff());
  std::printf(
      "  signal of a contact %s dB (difference: a disc in the middle, radius %s of the "
      "sheet's, %s of its conductivity)\n",
      fixed(c.snr_difference, 1).c_str(), number_text(c.contact_radius).c_str(),
      number_text(c.contact_ratio).c_str());
  std::printf("  drift               %s %% of the level, %s %% in all channels\n",
              fixed(100 * c.drift_level, 3).c_str(), fixed(100 * c.drift, 3).c_str());
  std::printf("  reciprocity         to %s %%\n", fixed(100 * c.reciprocity_error, 2).c_str());
  std::printf("  background          %s S/m fits, to %s %% of the voltages\n",
              number_text(c.background).c_str(), fixed(100 * c.misfit, 1).c_str());
  const std::string dead = joined(c.dead_electrodes);
  std::printf("  dead electrodes     %s\n", dead.empty() ? "none" : dead.c_str());
  for (const std::string& warning : warnings_of(c)) std::printf("  warning: %s\n", warning.c_str());
  std::printf("%s\n", printable_path(arguments.output).c_str());
  return done;
}

struct ReconstructArguments {
  ReconstructOptions options;
  std::string csv;
  std::string png;
  std::vector<std::uint64_t> png_frames;
};

void print_summary(const ReconstructSummary& summary, const std::filesystem::path& output) {
  std::printf("%llu frames in %s, %llu not converged, %llu undefined, %llu suspect\n",
              static_cast<unsigned long long>(summary.frames),
              printable_path(output.string()).c_str(),
              static_cast<unsigned long long>(summary.not_converged),
              static_cast<unsigned long long>(summary.undefined),
              static_cast<unsigned long long>(summary.suspect));
  constexpr const char* reasons[] = {"a dead electrode",
                                     "more noise than the solver was fitted for",
                                     "voltages out of the range that it was fitted for",
                                     "voltages that no contacts of the solver's model explain",
                                     "voltages of the opposite sign of the reference's",
                                     "a level that no contacts on this sheet cause",
                                     "a change that no contacts on this sheet cause",
                                     "a reference unlike those of the other frames"};
  for (std::size_t bit = 0; bit < std::size(reasons); ++bit) {
    const auto frames = static_cast<unsigned long long>(summary.with_reason[bit]);
    if (frames > 0) std::printf("  %llu with %s\n", frames, reasons[bit]);
  }
  for (const std::string& fault : summary.faults) std::printf("  %s\n", fault.c_str());
  if (!summary.checked) {
    std::printf(
        "  frames were checked for electrodes that read zero alone: the limits of noise and range\n"
        "  need a --calibration, or a solver that was fitted on 100 validation frames or more, by "
        "this version\n");
  }
  std::printf("%s\n", printable_lines(summary.reference).c_str());
}

ExitCode reconstruct(const ReconstructArguments& arguments) {
  const ReconstructOptions& options = arguments.options;
  // No output may be another file of the call.
  std::vector<std::filesystem::path> others = {options.frames.input, options.solver,
                                               options.output};
  if (!arguments.csv.empty()) {
    require_table_of_images(arguments.csv, others);
    others.emplace_back(arguments.csv);
  }
  if (!arguments.png.empty()) require_picture(arguments.png, others);
  SolverRegistry registry;
  if (!options.plugin.empty()) {
    require_image_output(options.output, {options.plugin});
    registry.add_library(options.plugin);
    registry.describe_libraries();
    for (const SolverRegistry::UnusableLibrary& library : registry.unusable_libraries()) {
      throw InputError(library.file.string() + ": " + library.how + " when it was loaded; mend it");
    }
  }
  const ReconstructSummary summary = reconstruct_file(options, registry);
  if (!arguments.csv.empty()) write_table_of_images(options.output, arguments.csv);
  if (!arguments.png.empty()) draw_images(options.output, arguments.png_frames, arguments.png);
  print_summary(summary, options.output);
  return done;
}

struct ScoreArguments {
  ScoreOptions options;
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
  section.columns = {
      Column("metric", Align::left), "mean", "95 %", "median", "frames", "undefined"};
  for (const Metric metric : kMetrics) {
    const MetricSummary& summary = scores.metrics[metric];
    const int decimals = decimals_of(metric);
    const std::string interval = summary.ci95 ? interval_text(fixed(summary.ci95->low, decimals),
                                                              fixed(summary.ci95->high, decimals))
                                              : "—";
    section.rows.push_back({Cell(axis_title(metric)), number_cell(summary.mean, decimals),
                            Cell(interval), number_cell(summary.median, decimals),
                            Cell(std::to_string(summary.count)),
                            Cell(std::to_string(summary.undefined))});
  }
  section.notes.push_back(std::to_string(scores.frames) + " frames, " +
                          std::to_string(scores.undefined_frames) + " without a usable image, " +
                          std::to_string(scores.flagged_frames) +
                          " flagged (they count); true contacts: " + scores.contacts +
                          ". `ertbench list` says what the metrics are.");
  for (const std::string& note : scores.notes) section.notes.push_back("warning: " + note);
  return {"", "", {section}, {}, ""};
}

ExitCode score(const ScoreArguments& arguments) {
  if (!arguments.json.empty()) {
    require_output(arguments.json, {arguments.options.images, arguments.options.truth},
                   {"scores", holds_scores});
  }
  const ImageScores scores = score_images(arguments.options);
  if (!arguments.json.empty()) {
    write_file_atomically(arguments.json, json_text(to_json(scores), 1) + "\n");
  }
  std::printf("%s", terminal_of(table_of(scores)).c_str());
  return done;
}

}  // namespace

Action add_calibrate(CLI::App& command) {
  const auto arguments = std::make_shared<CalibrateArguments>();
  command.description("Noise, drift, electrodes and background, from frames without contact");
  command
      .add_option(
          "FRAMES", arguments->frames.input,
          "Frames without contact, ten or more: HDF5, MATLAB, tables of\ntext, .dat, .get or .eit")
      ->required();
  command
      .add_option("--out", arguments->output,
                  "JSON, for `reconstruct --calibration` and for \"calibration\" of an experiment")
      ->required();
  add_frame_options(command, arguments->frames);
  command.add_option("--rows", arguments->frames.background,
                     "Only these rows, FIRST-LAST, counted from 0");
  command.add_flag("--fix", arguments->fix,
                   "Where the voltages are not what the sensor's model expects, read them as\n"
                   "would mend it");
  command.add_flag("--force", arguments->force,
                   "Calibrate whatever the check says, without frames that are unlike the others");
  command.footer(
      "Example:\n  ertbench calibrate empty.h5 --sensor sensor.json --out calibration.json\n"
      "  ertbench calibrate recording.csv --rows 0-19 --unit mV --out calibration.json\n"
      "See docs/own_frames.md.");
  return [arguments] { return calibrate(*arguments); };
}

Action add_reconstruct(CLI::App& command) {
  const auto arguments = std::make_shared<ReconstructArguments>();
  ReconstructOptions& options = arguments->options;
  command.description("Images from a file of frames");
  command
      .add_option("--solver", options.solver,
                  "One entry of a \"solvers\" list, JSON, or a name that `list --fitted` shows")
      ->required();
  command
      .add_option("--input", options.frames.input,
                  "HDF5 with /voltages [N, channels] and /reference_voltages [channels], MATLAB\n"
                  "v7.3, Octave's save -hdf5, CSV with a frame in each line, or .eit files of\n"
                  "Sciospec's instruments (one, or a folder of them)")
      ->required();
  command
      .add_option("--output", options.output,
                  "HDF5 with /conductivity_change [N, rows, columns] S/m, /status [N] and, of\n"
                  "solvers that know contacts themselves, /contacts [N, 8, 6];\n"
                  "of what is there, only such a file is written over")
      ->required();
  add_frame_options(command, options.frames);
  command.add_option("--background", options.frames.background,
                     "Frames without contact, whose mean is the reference: a file like the input,\n"
                     "or rows of the input, FIRST-LAST, counted from 0");
  command
      .add_option_function<std::string>(
          "--difference",
          [&options](const std::string& kind) { options.frames.normalised = kind == "normalised"; },
          "Changes of the voltages: absolute (the default), or normalised: v / v0 times the\n"
          "model's v0, which the channels' gains, units and signs leave as they are")
      ->check(CLI::IsMember({"absolute", "normalised"}));
  command.add_option("--calibration", options.frames.calibration,
                     "What `ertbench calibrate` wrote: its background, its reference where there\n"
                     "is no other, and its noise for what is \"auto\" and the check of frames");
  command.add_flag("--fix", options.fix,
                   "Where the reference voltages are not what the sensor's model expects, read\n"
                   "the frames as would mend it");
  command.add_flag("--force", options.force, "Image the frames whatever the check says");
  command.add_option("--png", arguments->png,
                     "Also draw images: up to 12, over the whole file, as PNG and SVG");
  command.add_option("--png-frames", arguments->png_frames, "These frames, counted from 0: 0,5,9")
      ->delimiter(',')
      ->expected(1, static_cast<int>(most_pictured));
  command.add_option("--csv", arguments->csv, "Also write the images as a table, a frame a line");
  command.add_option("--plugin", options.plugin, "Shared library of your own solvers");
  command.footer(
      "Example:\n  echo '{\"type\": \"one-step-gn\", \"prior\": \"noser\", \"lambda\": 0.1}' > "
      "gn.json\n"
      "  ertbench reconstruct --solver gn.json --input test.h5 --output images.h5\n"
      "  ertbench reconstruct --solver lean-net-8 --input test.h5 --output images.h5\n"
      "  ertbench reconstruct --solver gn.json --input frames.csv --unit mV --background 0-19 \\\n"
      "    --output images.h5 --png images.png\n"
      "See docs/own_frames.md.");
  return [arguments] { return reconstruct(*arguments); };
}

Action add_score(CLI::App& command) {
  const auto arguments = std::make_shared<ScoreArguments>();
  command.description("All metrics of images that were made elsewhere");
  command
      .add_option("IMAGES", arguments->options.images,
                  "HDF5 with /conductivity_change (or /conductivity) [N, rows, columns] S/m, and\n"
                  "/status [N] where it is there (2: undefined)")
      ->required();
  command
      .add_option("TRUTH", arguments->options.truth,
                  "A dataset file, or HDF5 with /conductivity [N, rows, columns] S/m")
      ->required();
  command.add_option("--sensor", arguments->options.sensor,
                     "JSON of the sensor (default: what the files say, else EIDORS's d2s)");
  command.add_option("--dataset", arguments->options.dataset,
                     "Dataset of the images in their file");
  command.add_option("--json", arguments->json, "Also write the table as JSON");
  command.footer(
      "Example:\n  ertbench reconstruct --solver gn.json --input test.h5 --output images.h5\n"
      "  ertbench score images.h5 test.h5 --json scores.json\n"
      "See docs/own_frames.md.");
  return [arguments] { return score(*arguments); };
}

}  // namespace ertbench
