#include "bench/live/live_files.h"

#include <charconv>
#include <cmath>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/quantile.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/dataset_layout.h"

namespace ertbench {
namespace {

namespace layout = dataset_layout;

Frames changes_of(const FramesOfFile& frames, const Sensor& sensor, const std::string& file) {
  if (!frames.reference) throw InputError(file + ": has no /reference_voltages [channels] V");
  frames.require(sensor, file);
  if (!frames.voltages.allFinite()) throw InputError(file + ": /voltages: must be finite");
  return frames.voltages.rowwise() - *frames.reference;
}

}  // namespace

void FramesOfFile::require(const Sensor& expected, const std::string& file) const {
  if (sensor && !(*sensor == expected)) {
    throw InputError(file + ": its frames are of another sensor than the solver's");
  }
  const Eigen::Index channels =
      voltages.size() == 0 && reference ? reference->size() : voltages.cols();
  if (channels != expected.channels()) {
    throw InputError(file + ": its frames have " + std::to_string(channels) +
                     " channels, those of the solver's sensor " +
                     std::to_string(expected.channels()) + "; name theirs by --sensor");
  }
}

FramesOfFile read_frames_of(const std::string& name, const std::string& option) {
  if (name.empty()) throw InputError(option + ": names no file");
  const Hdf5File file = Hdf5File::open(name);
  FramesOfFile out;
  if (file.has_attribute("/", "sensor")) out.sensor = sensor_of(file);
  auto channels = out.sensor ? static_cast<std::uint64_t>(out.sensor->channels()) : 0;
  if (file.has(layout::reference_voltages)) {
    channels = file.require_shape(layout::reference_voltages, {channels})[0];
    out.reference = file.read_vector(layout::reference_voltages).transpose();
  }
  if (option == "--reference" && !file.has(layout::voltages)) return out;
  const std::uint64_t frames = file.require_shape(layout::voltages, {0, channels})[0];
  out.voltages = file.read_rows(layout::voltages, 0, frames, true);
  if (file.has(layout::time)) {
    file.require_shape(layout::time, {frames});
    const Eigen::VectorXd times = file.read_vector(layout::time);
    out.times_s.assign(times.begin(), times.end());
  }
  return out;
}

std::string quiet_file(const std::string& text) { return text.substr(0, text.rfind('@')); }

QuietFrames read_quiet(const std::string& text, const Sensor& sensor) {
  const std::string name = quiet_file(text);
  double rate = 0;
  if (const auto at = text.rfind('@'); at != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + at + 1, end, rate);
    if (read.ec != std::errc() || read.ptr != end || !(rate > 0)) {
      throw InputError("--quiet: must be FILE.h5 or FILE.h5@RATE, got \"" + printable(text) + "\"");
    }
  }
  const FramesOfFile frames = read_frames_of(name, "--quiet");
  QuietFrames out;
  out.changes = changes_of(frames, sensor, name);
  out.runs.first = {0};
  std::vector<double> steps_s;
  for (std::size_t f = 1; f < frames.times_s.size(); ++f) {
    const double step_s = frames.times_s[f] - frames.times_s[f - 1];
    if (step_s > 0) {
      steps_s.push_back(step_s);
    } else {
      out.runs.first.push_back(f);
    }
  }
  out.runs.first.push_back(static_cast<std::size_t>(frames.voltages.rows()));
  if (rate == 0 && steps_s.empty()) {
    throw InputError("--quiet: " + name + " has no /time that says how many frames came in a " +
                     "second; write " + name + "@RATE");
  }
  out.runs.frame_rate = rate > 0 ? rate : 1 / median(steps_s);
  return out;
}

ForceFrames read_forces(const std::string& name, const Sensor& sensor) {
  const DatasetFile file{name};
  if (!(file.sensor() == sensor)) {
    throw InputError(name + ": its frames are of another sensor than the solver's");
  }
  const std::vector<Scene> scenes = file.scenes(0, file.size());
  const Frames voltages = file.voltages(0, file.size());
  ForceFrames out;
  std::vector<Eigen::Index> rows;
  for (std::size_t f = 0; f < scenes.size(); ++f) {
    if (scenes[f].contacts.size() != 1 || !(scenes[f].contacts[0].force_N > 0)) continue;
    rows.push_back(static_cast<Eigen::Index>(f));
    out.forces_N.push_back(scenes[f].contacts[0].force_N);
  }
  if (rows.empty()) {
    throw InputError("--forces: " + name + " has no frame with one touch of a known force; " +
                     "generate a set of touches (docs/touch.md)");
  }
  out.changes.resize(std::ssize(rows), voltages.cols());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    out.changes.row(static_cast<Eigen::Index>(r)) =
        voltages.row(rows[r]) - file.reference_voltages().transpose();
  }
  return out;
}

}  // namespace ertbench
