#include "bench/run/calibrate_file.h"

#include <nlohmann/json.hpp>
#include <tuple>

#include "bench/run/reconstruct.h"
#include "core/atomic_file.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "core/output_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t least_frames = 10;
constexpr std::uint64_t most_frames = 1000000;

bool is_calibration(const fs::path& file) {
  try {
    read_calibration(file);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

CalibrationOutcome calibrate_file(const OwnFramesOptions& given, const fs::path& output, bool fix,
                                  bool force) {
  OwnFramesOptions options = given;
  options.needs_reference = false;
  options.background.clear();
  options.calibration.clear();
  survive_reading(options.input, [&] { OwnFrames(options).source().read(0, 1); });
  OwnFrames frames(options);
  require_output(output, frames.inputs(), {"calibration", is_calibration});

  std::uint64_t first = 0;
  std::uint64_t last = frames.frames() - 1;
  if (!given.background.empty()) {
    const auto rows = rows_of(given.background);
    if (!rows || rows->first > rows->second || rows->second > last) {
      throw InputError("--rows: must be FIRST-LAST, counted from 0, among the " +
                       std::to_string(frames.frames()) + " frames of " + options.input.string() +
                       ", got " + given.background);
    }
    std::tie(first, last) = *rows;
  }
  const std::uint64_t count = last + 1 - first;
  if (count < least_frames || count > most_frames) {
    throw InputError(options.input.string() + ": noise is known from " +
                     std::to_string(least_frames) + " to " + std::to_string(most_frames) +
                     " frames without contact, these are " + std::to_string(count) +
                     "; record more, or choose by --rows");
  }
  Frames voltages = frames.voltages(first, count);
  const Eigen::VectorXd mean = voltages.colwise().mean().transpose();
  CalibrationOutcome outcome;
  outcome.verdict = check_reference(frames.sensor(), mean, {});
  ReferenceVerdict& verdict = outcome.verdict;
  using State = ReferenceVerdict::State;
  // What a level would be mended by is what is wanted here.
  const bool level_alone = verdict.state == State::mendable && verdict.is_level_alone;
  if (verdict.state != State::sound && !level_alone && !force) {
    if (!fix || verdict.state == State::beyond_help) {
      throw InputError(options.input.string() + ": " + verdict.text() +
                       "\n  nothing was calibrated; " +
                       (verdict.state == State::mendable ? "--fix reads the frames so, " : "") +
                       "--force calibrates on them as they are");
    }
    frames.mend(verdict);
    voltages = frames.voltages(first, count);
  }
  outcome.calibration = calibrate(frames.sensor(), voltages);
  if (!(outcome.calibration.level > 0)) {
    throw InputError(options.input.string() +
                     ": the voltages have the other sign than the model's; --fix turns them");
  }
  nlohmann::json json = to_json(outcome.calibration);
  json["source"] = frames.description();
  json["source"]["rows"] = {first, last};
  write_file_atomically(output, json_text(printable_json(json, 4096), 1) + "\n");
  return outcome;
}

}  // namespace ertbench
