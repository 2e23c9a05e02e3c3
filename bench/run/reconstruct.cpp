#include "bench/run/reconstruct.h"

#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/run/reconstruct_output.h"
#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json_reader.h"
#include "core/json_text.h"
#include "core/process.h"
#include "core/progress.h"
#include "core/replace_file.h"
#include "forward/data/dataset_file.h"
#include "forward/data/dataset_layout.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
namespace layout = dataset_layout;

constexpr std::uint64_t streamed_frames = 1024;

/// A file of frames, checked.
struct FramesFile {
  explicit FramesFile(const fs::path& path) : file(Hdf5File::open(path)), sensor(sensor_of(file)) {
    const auto channels = static_cast<std::uint64_t>(sensor.channels());
    frames = file.require_shape(layout::voltages, {0, channels})[0];
    file.require_shape(layout::reference_voltages, {channels});
    reference = file.read_vector(layout::reference_voltages).transpose();
    if (file.has(layout::scenes_written) &&
        file.read_rows(layout::scenes_written, 0, 1)(0, 0) != static_cast<double>(frames)) {
      throw InputError(path.string() + ": is not finished; generate it again to go on");
    }
  }

  Frames changes(std::uint64_t first, std::uint64_t count) const {
    return file.read_rows(layout::voltages, first, count).rowwise() - reference;
  }

  Hdf5File file;
  Sensor sensor;
  std::uint64_t frames = 0;
  Eigen::RowVectorXd reference;
};

/// Reads the whole file in a child: the library does not survive every damaged file. What the child
/// finds wrong in an orderly way, the reading that counts finds again.
void survive_reading(const fs::path& path) {
  constexpr double time_limit_s = 600;  // for a library that never comes back
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto&) {
        try {
          read_frames(path);
        } catch (const std::exception&) {
        }
      },
      {time_limit_s, machine_memory_bytes() / 2});
  if (!outcome.finished) {
    throw InputError(path.string() +
                     ": is damaged: the HDF5 library cannot get through it; write it again");
  }
}

std::unique_ptr<Solver> solver_from(const fs::path& spec_file, const Sensor& sensor,
                                    SolverRegistry& registry) {
  json spec = read_json_file(spec_file);
  std::optional<fs::path> checkpoint;
  if (spec.is_object() && spec.contains("checkpoint")) {
    checkpoint = JsonObject(spec, spec_file.string(), "").text("checkpoint");
    if (checkpoint->is_relative()) checkpoint = spec_file.parent_path() / *checkpoint;
    spec.erase("checkpoint");
  }
  std::unique_ptr<Solver> solver = registry.make(JsonObject(spec, spec_file.string(), ""));
  if (checkpoint) {
    solver->load(*checkpoint, sensor);
  } else {
    FitInput fit;
    fit.sensor = sensor;
    try {
      solver->fit(fit);
    } catch (const InputError& e) {
      throw InputError(spec_file.string() + ": " + e.what());
    }
  }
  return solver;
}

void count_report(const FrameReport& report, ReconstructSummary& summary) {
  summary.not_converged += report.status == FrameStatus::not_converged;
  summary.undefined += report.status == FrameStatus::undefined;
  summary.suspect += report.status == FrameStatus::suspect;
  summary.dead_electrode += (report.reasons & dead_electrode) != 0;
  summary.noise += (report.reasons & noise) != 0;
  summary.out_of_range += (report.reasons & out_of_range) != 0;
  summary.unexplained += (report.reasons & unexplained) != 0;
}

/// In a process of its own.
ReconstructSummary reconstruct_here(const fs::path& spec_file, const fs::path& input,
                                    const fs::path& output, const fs::path& aside,
                                    SolverRegistry& registry) {
  const FramesFile frames(input);
  const std::unique_ptr<Solver> solver = solver_from(spec_file, frames.sensor, registry);

  ReconstructSummary summary;
  summary.frames = frames.frames;
  summary.checked = solver->fit_report().frame_check.empty();
  const auto write = [&](const fs::path& place) {
    Hdf5File out = Hdf5File::create(place);
    const auto grid = static_cast<std::uint64_t>(frames.sensor.image_grid);
    out.create_dataset("/conductivity_change", {frames.frames, grid, grid});
    out.write_text("/conductivity_change", "units", "S/m");
    out.write_text("/conductivity_change", "description",
                   "change from the background [frame, row, column]: row 0 at y = -1, column 0 at "
                   "x = -1");
    out.create_dataset("/status", {frames.frames}, Hdf5File::Number::uint8);
    out.write_text(
        "/status", "description",
        "0 ok, 1 not converged, 2 undefined (image is NaN), 3 suspect (an image, but the "
        "frame is not one to trust: /reason says why)");
    out.create_dataset("/reason", {frames.frames}, Hdf5File::Number::uint8);
    out.write_text("/reason", "description",
                   "sum of 1 a dead electrode, 2 noise above what the solver was fitted for, 4 "
                   "voltages out of the range that it was fitted for, 8 explained by no contacts "
                   "of the solver's model; 0 none");
    out.write_text("/", "solver", json_text(printable_json(solver->parameters())));
    Progress progress("reconstructing");
    for (std::uint64_t first = 0; first < frames.frames; first += streamed_frames) {
      const std::uint64_t count = std::min(streamed_frames, frames.frames - first);
      const Frames changes = frames.changes(first, count);
      Images images(changes.rows(), frames.sensor.pixels());
      std::vector<FrameReport> reports(count);
      solver->reconstruct(changes, images, reports);
      RowMajorMatrix status(changes.rows(), 1);
      RowMajorMatrix reason(changes.rows(), 1);
      for (Eigen::Index i = 0; i < changes.rows(); ++i) {
        FrameReport& report = reports[static_cast<std::size_t>(i)];
        if (!images.row(i).allFinite()) report.status = FrameStatus::undefined;
        if (report.status == FrameStatus::undefined) images.row(i).setConstant(std::nan(""));
        count_report(report, summary);
        status(i, 0) = static_cast<double>(report.status);
        reason(i, 0) = report.reasons;
      }
      out.write_rows("/conductivity_change", first, images);
      out.write_rows("/status", first, status);
      out.write_rows("/reason", first, reason);
      progress.update(first + count, frames.frames);
    }
    out.close();
  };
  replace_file(output, write, aside);
  return summary;
}

json to_json(const ReconstructSummary& s) {
  return {s.frames, s.not_converged, s.undefined,   s.suspect, s.dead_electrode,
          s.noise,  s.out_of_range,  s.unexplained, s.checked};
}

ReconstructSummary summary_from_json(const json& value) {
  return {value.at(0), value.at(1), value.at(2), value.at(3), value.at(4),
          value.at(5), value.at(6), value.at(7), value.at(8)};
}

}  // namespace

void read_frames(const fs::path& input) {
  const FramesFile file(input);
  for (std::uint64_t first = 0; first < file.frames; first += streamed_frames) {
    file.changes(first, std::min(streamed_frames, file.frames - first));
  }
}

ReconstructSummary reconstruct_file(const fs::path& spec_file, const fs::path& input,
                                    const fs::path& output, SolverRegistry& registry) {
  require_image_output(output, reconstruction_inputs(spec_file, input));
  survive_reading(input);
  const fs::path aside = aside_of(output);
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        registry.allow_plugins();
        json said;
        try {
          said["summary"] = to_json(reconstruct_here(spec_file, input, output, aside, registry));
        } catch (const InputError& wrong) {
          said["refused"] = wrong.what();
        } catch (const std::bad_alloc&) {
          said["no_memory"] = true;
        } catch (const std::exception& exception) {
          said["failed"] = exception.what();
        }
        send(json_text(said));
      },
      {std::numeric_limits<double>::infinity(), machine_memory_bytes() / 10 * 9},
      StandardError::shared);
  if (!outcome.finished || outcome.messages.empty()) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    throw InputError(spec_file.string() + ": the solver ended its process (" + outcome.end.text() +
                     "); " + output.string() + " was not written");
  }
  const json said = parse_json(outcome.messages.back(), "what the solver's process said");
  if (said.contains("refused")) throw InputError(said.at("refused").get<std::string>());
  if (said.contains("no_memory")) throw std::bad_alloc();
  if (said.contains("failed")) throw std::runtime_error(said.at("failed").get<std::string>());
  return summary_from_json(said.at("summary"));
}

}  // namespace ertbench
