#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/cli/frame_options.h"
#include "bench/run/image_files.h"
#include "bench/run/reconstruct.h"
#include "bench/run/reconstruct_output.h"
#include "core/errors.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct ReconstructArguments {
  std::string solver;
  std::string input;
  std::string output;
  std::string plugin;
  std::string calibration;
  std::string csv;
  std::string png;
  std::vector<std::uint64_t> png_frames;
  bool fix = false;
  bool force = false;
  std::shared_ptr<OwnFramesOptions> frames = std::make_shared<OwnFramesOptions>();
};

void print_summary(const ReconstructArguments& arguments, const ReconstructSummary& summary) {
  std::printf("%llu frames in %s, %llu not converged, %llu undefined, %llu suspect\n",
              static_cast<unsigned long long>(summary.frames),
              printable_path(arguments.output).c_str(),
              static_cast<unsigned long long>(summary.not_converged),
              static_cast<unsigned long long>(summary.undefined),
              static_cast<unsigned long long>(summary.suspect));
  const std::pair<const char*, std::uint64_t> reasons[] = {
      {"a dead electrode", summary.dead_electrode},
      {"more noise than the solver was fitted for", summary.noise},
      {"voltages out of the range that it was fitted for", summary.out_of_range},
      {"voltages that no contacts of the solver's model explain", summary.unexplained}};
  for (const auto& [reason, frames] : reasons) {
    if (frames > 0)
      std::printf("  %llu with %s\n", static_cast<unsigned long long>(frames), reason);
  }
  if (!summary.checked) {
    std::printf(
        "  frames were checked for electrodes that read zero alone: the limits of noise and range\n"
        "  need a --calibration, or a solver that was fitted on 100 validation frames or more, by "
        "this version\n");
  }
  std::printf("%s\n", printable_lines(summary.reference).c_str());
}

ExitCode reconstruct(const ReconstructArguments& arguments) {
  ReconstructOptions options;
  options.solver = arguments.solver;
  options.frames = *arguments.frames;
  options.frames.input = arguments.input;
  options.frames.calibration = arguments.calibration;
  options.output = arguments.output;
  options.fix = arguments.fix;
  options.force = arguments.force;
  const std::vector<std::filesystem::path> inputs = {arguments.input, arguments.solver,
                                                     arguments.output};
  if (!arguments.csv.empty()) require_table_of_images(arguments.csv, inputs);
  if (!arguments.png.empty()) require_picture(arguments.png, inputs);
  SolverRegistry registry;
  if (!arguments.plugin.empty()) {
    require_image_output(arguments.output, {arguments.plugin});
    registry.add_library(arguments.plugin);
    registry.describe_libraries();
    for (const SolverRegistry::UnusableLibrary& library : registry.unusable_libraries()) {
      throw InputError(library.file.string() + ": " + library.how + " when it was loaded; mend it");
    }
  }
  const ReconstructSummary summary = reconstruct_file(options, registry);
  if (!arguments.csv.empty()) write_table_of_images(arguments.output, arguments.csv);
  if (!arguments.png.empty()) draw_images(arguments.output, arguments.png_frames, arguments.png);
  print_summary(arguments, summary);
  return done;
}

}  // namespace

Action add_reconstruct(CLI::App& command) {
  const auto arguments = std::make_shared<ReconstructArguments>();
  command.description("Images from a file of frames");
  command.add_option("--solver", arguments->solver, "One entry of a \"solvers\" list, JSON")
      ->required();
  command
      .add_option("--input", arguments->input,
                  "HDF5 with /voltages [N, channels] and /reference_voltages [channels], MATLAB\n"
                  "v7.3, Octave's save -hdf5, CSV with a frame in each line, or .eit files of\n"
                  "Sciospec's instruments (one, or a folder of them)")
      ->required();
  command
      .add_option("--output", arguments->output,
                  "HDF5 with /conductivity_change [N, rows, columns] S/m, /status [N] and, of\n"
                  "solvers that know contacts themselves, /contacts [N, 8, 6];\n"
                  "of what is there, only such a file is written over")
      ->required();
  add_frame_options(command, arguments->frames);
  command.add_option("--background", arguments->frames->background,
                     "Frames without contact, whose mean is the reference: a file like the input,\n"
                     "or rows of the input, FIRST-LAST, counted from 0");
  command.add_option("--calibration", arguments->calibration,
                     "What `ertbench calibrate` wrote: its background, its reference where there\n"
                     "is no other, and its noise for what is \"auto\" and the check of frames");
  command.add_flag("--fix", arguments->fix,
                   "Where the reference voltages are not what the sensor's model expects, read\n"
                   "the frames as would mend it");
  command.add_flag("--force", arguments->force, "Image the frames whatever the check says");
  command.add_option("--png", arguments->png,
                     "Also draw images: up to 12, over the whole file, as PNG and SVG");
  command.add_option("--png-frames", arguments->png_frames, "These frames, counted from 0: 0,5,9")
      ->delimiter(',')
      ->expected(1, static_cast<int>(most_pictured));
  command.add_option("--csv", arguments->csv, "Also write the images as a table, a frame a line");
  command.add_option("--plugin", arguments->plugin, "Shared library of your own solvers");
  command.footer(
      "Example:\n  echo '{\"type\": \"one-step-gn\", \"prior\": \"noser\", \"lambda\": 0.1}' > "
      "gn.json\n"
      "  ertbench reconstruct --solver gn.json --input test.h5 --output images.h5\n"
      "  ertbench reconstruct --solver gn.json --input frames.csv --unit mV --background 0-19 \\\n"
      "    --output images.h5 --png images.png\n"
      "See docs/own_frames.md.");
  return [arguments] { return reconstruct(*arguments); };
}

}  // namespace ertbench
