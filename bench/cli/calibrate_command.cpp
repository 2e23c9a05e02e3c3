#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/cli/frame_options.h"
#include "bench/run/calibrate_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

struct CalibrateArguments {
  std::string output;
  bool fix = false;
  bool force = false;
  std::string input;
  std::shared_ptr<OwnFramesOptions> frames = std::make_shared<OwnFramesOptions>();
};

ExitCode calibrate(const CalibrateArguments& arguments) {
  OwnFramesOptions options = *arguments.frames;
  options.input = arguments.input;
  const CalibrationOutcome outcome =
      calibrate_file(options, arguments.output, arguments.fix, arguments.force);
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
  std::string dead;
  for (const int e : c.dead_electrodes) dead += (dead.empty() ? "" : ", ") + std::to_string(e);
  std::printf("  dead electrodes     %s\n", dead.empty() ? "none" : dead.c_str());
  std::printf("%s\n", printable_path(arguments.output).c_str());
  return done;
}

}  // namespace

Action add_calibrate(CLI::App& command) {
  const auto arguments = std::make_shared<CalibrateArguments>();
  command.description("Noise, drift, electrodes and background, from frames without contact");
  command
      .add_option("FRAMES", arguments->input,
                  "Frames without contact, ten or more: HDF5, MATLAB v7.3, CSV or .eit")
      ->required();
  command
      .add_option("--out", arguments->output,
                  "JSON, for `reconstruct --calibration` and for \"calibration\" of an experiment")
      ->required();
  add_frame_options(command, arguments->frames);
  command.add_option("--rows", arguments->frames->background,
                     "Only these rows, FIRST-LAST, counted from 0");
  command.add_flag("--fix", arguments->fix,
                   "Where the voltages are not what the sensor's model expects, read them as\n"
                   "would mend it");
  command.add_flag("--force", arguments->force, "Calibrate whatever the check says");
  command.footer(
      "Example:\n  ertbench calibrate empty.h5 --sensor sensor.json --out calibration.json\n"
      "  ertbench calibrate recording.csv --rows 0-19 --unit mV --out calibration.json\n"
      "See docs/own_frames.md.");
  return [arguments] { return calibrate(*arguments); };
}

}  // namespace ertbench
