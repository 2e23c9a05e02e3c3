#include "frames/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <tuple>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/process.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/measured_file.h"
#include "frames/calibration.h"
#include "frames/reference_check.h"
#include "solvers/check/checked_solver.h"
#include "solvers/check/stored_solver.h"
#include "solvers/registry/named_solver.h"
#include "solvers/registry/registry.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uint64_t streamed_frames = 1024;
constexpr Eigen::Index most_written = written_contacts[0];
constexpr Eigen::Index contact_columns = written_contacts[1];

bool is_stored(const NamedSolver& named) { return named.entry->contains("checkpoint"); }

/// What the solver is fitted for: a stored one keeps its current and, if calibrated, background.
Sensor sensor_of(const NamedSolver& named, const OwnFrames& frames) {
  if (!is_stored(named)) return frames.sensor();
  Sensor out = frames.declared_sensor();
  JsonObject object(*named.entry, named.source, "");
  const fs::path file = fitted_file(object.text("checkpoint"), object.folder());
  try {
    const json sensor = json_attribute(Hdf5File::open(file), "sensor");
    const Sensor stored = sensor_from_json(JsonObject(sensor, file.string(), "/sensor"));
    out.drive_current = stored.drive_current;
    if (frames.calibration()) out.background = stored.background;
  } catch (const InputError&) {  // is reported when the solver is loaded
  }
  return out;
}

/// Channels that were left out are not asked of a solver that is fitted here; a stored one has all.
std::unique_ptr<Solver> solver_from(const NamedSolver& given, const OwnFrames& frames,
                                    const Sensor& sensor, SolverRegistry& registry) {
  NamedSolver named = given;
  FitInput fit;
  const bool stored = is_stored(named);
  fit.sensor = sensor;
  const TemporaryFolder folder("reconstruct");
  std::optional<DatasetFile> set;
  if (frames.calibration() && !stored) {
    write_calibrated_set(*frames.calibration(), fit.sensor, folder / "calibrated.h5", fit.threads);
    fit.validation = &set.emplace(folder / "calibrated.h5");
  } else if (!stored && named.entry->is_object()) {
    json entry = *named.entry;
    complete_contacts(entry, frames.sensor(), frames.reference().transpose(),
                      frames.background_noise());
    named.entry = JsonValue(std::move(entry));
  }
  return fitted_solver(named, fit, registry);
}

void count_report(const FrameReport& report, ReconstructSummary& summary) {
  summary.not_converged += report.status == FrameStatus::not_converged;
  summary.undefined += report.status == FrameStatus::undefined;
  summary.suspect += report.status == FrameStatus::suspect;
  for (std::size_t bit = 0; bit < summary.with_reason.size(); ++bit) {
    summary.with_reason[bit] += report.reasons >> bit & 1;
  }
}

constexpr std::size_t most_said = 8;  ///< frames that a summary describes

/// Judges a frame by its voltages alone and enters the verdict into its report and the summary.
void judge(const OwnFrames& frames, std::uint64_t frame,
           const Eigen::Ref<const Eigen::RowVectorXd>& change, FrameReport& report,
           ReconstructSummary& summary) {
  const FrameVerdict verdict = frames.judge(frame, change, report);
  ertbench::report(verdict, report);
  if (verdict.faults == 0 || summary.faults.size() >= most_said) return;
  summary.faults.push_back("frame " + std::to_string(frame) + ": " + verdict.text());
}

/// Checks the reference, mends frames if asked and returns the text; throws if they do not fit.
std::string check_frames(const ReconstructOptions& options, OwnFrames& frames) {
  const ReferenceVerdict verdict = frames.check();
  const std::string text = verdict.text();
  if (settle(verdict, options.frames.input.string(), options.fix, options.force)) {
    frames.mend(verdict);
    return text + "\n  the frames were read so (--fix)";
  }
  if (verdict.state == ReferenceVerdict::State::sound) return text;
  return text + "\n  the frames were imaged as they are (--force)";
}

void describe(Hdf5File& out, const OwnFrames& frames, const Solver& solver) {
  const PixelGrid pixels = frames.sensor().image();
  const auto rows = static_cast<std::uint64_t>(pixels.rows());
  const auto columns = static_cast<std::uint64_t>(pixels.columns());
  const double unit_mm = frames.sensor().sheet->unit_mm();
  out.create_dataset("/conductivity_change", {frames.frames(), rows, columns});
  out.write_text("/conductivity_change", "units", "S/m");
  out.write_text("/conductivity_change", "description",
                 "change from the background [frame, row, column]: row 0 at the least y, column 0 "
                 "at the least x (/y_mm, /x_mm)");
  out.create_dataset("/status", {frames.frames()}, Hdf5File::Number::uint8);
  out.write_text("/status", "description",
                 "0 ok, 1 not converged, 2 undefined (image is NaN), 3 suspect (an image, but the "
                 "frame is not one to trust: /reason says why)");
  out.create_dataset("/reason", {frames.frames()}, Hdf5File::Number::uint8);
  out.write_text("/reason", "description",
                 "sum of 1 a dead electrode, 2 noise above what the solver was fitted for, 4 "
                 "voltages out of the range that it was fitted for, 8 explained by no contacts "
                 "of the solver's model, 16 voltages of the opposite sign, 32 a level and 64 a "
                 "change that this sheet cannot have, 128 a reference unlike the others'; 0 none");
  if (solver.contact_finder()) {
    out.create_dataset("/contacts", {frames.frames(), most_written, contact_columns});
    out.write_text("/contacts", "description",
                   "[frame, contact, column], the strongest first, NaN where there is none: x and "
                   "y of the centre, mm from the middle of the sheet; radius of the disc of its "
                   "area, mm; largest change of the conductivity, S/m; standard deviations of x "
                   "and y, mm, 0 where the solver knows none");
  }
  out.write_vector("/x_mm", unit_mm * pixels.centres_x().transpose());
  out.write_vector("/y_mm", unit_mm * pixels.centres_y().transpose());
  for (const char* axis : {"/x_mm", "/y_mm"}) {
    out.write_text(axis, "description", "centres of the pixels, mm from the sheet's own origin");
  }
  out.write_vector("/reference_voltages", frames.reference().transpose());
  out.write_text("/reference_voltages", "units", "V");
  out.write_text("/", "sensor", json_text(to_json(frames.sensor())));
  out.write_text("/", "solver", json_text(printable_json(solver.parameters())));
  out.write_text("/", "source", json_text(printable_json(frames.description(), 4096)));
  out.write_matrix("/channel_map", frames.map().table());
  out.write_text("/channel_map", "description",
                 "how channels were read [channel]: column of the input, the column that was taken "
                 "from it or -1, factor to V");
}

/// Writes /level if the solver estimates it: the change of the whole sheet beside the image's.
void write_level(Hdf5File& out, const RowMajorMatrix& level) {
  if ((level.array() == 0).all()) return;
  out.create_dataset("/level", {static_cast<std::uint64_t>(level.rows())});
  out.write_rows("/level", 0, level);
  out.write_text("/level", "description",
                 "relative change of the whole sheet's conductivity that was found beside what the "
                 "image shows [frame]");
}

/// Runs in a child process.
ReconstructSummary reconstruct_here(const ReconstructOptions& options, const fs::path& aside,
                                    SolverRegistry& registry) {
  OwnFrames frames(options.frames);
  require_image_output(options.output, frames.inputs());
  const NamedSolver named = read_named_solver(options.solver);
  const Sensor fitted = sensor_of(named, frames);
  const std::unique_ptr<Solver> solver = solver_from(named, frames, fitted, registry);
  // Voltages go with the current over the background, images with the background.
  const Sensor& own = is_stored(named) ? frames.declared_sensor() : fitted;
  const double ratio = own.background / fitted.background;
  const double gain = ratio * fitted.drive_current / own.drive_current;
  const auto& checked = dynamic_cast<const CheckedSolver&>(*solver);
  const bool completes = is_stored(named) && !frames.left_out().empty();

  ReconstructSummary summary;
  summary.reference = check_frames(options, frames);
  if (completes) {
    summary.reference +=
        "\n  note: the solver has all channels; those left out were estimated from the others";
  }
  if (gain != 1 || ratio != 1) {
    summary.reference += "\n  note: fitted for " + number_text(fitted.background) + " S/m and " +
                         number_text(fitted.drive_current) + " A: voltages are multiplied by " +
                         fixed(gain, 3) + ", images by " + fixed(ratio, 3);
  }
  frames.fill_reference();
  summary.frames = frames.frames();
  summary.checked = solver->fit_report().frame_check.empty();
  const std::vector<Eigen::Matrix2d> twins = twin_symmetries(frames.sensor());
  const auto write = [&](const fs::path& place) {
    Hdf5File out = Hdf5File::create(place);
    describe(out, frames, *solver);
    if (!twins.empty()) out.write_text("/conductivity_change", "twins", text_of_twins(twins));
    RowMajorMatrix level(static_cast<Eigen::Index>(frames.frames()), 1);
    Progress progress("reconstructing");
    for (std::uint64_t first = 0; first < frames.frames(); first += streamed_frames) {
      const std::uint64_t count = std::min(streamed_frames, frames.frames() - first);
      const Frames changes = frames.changes(first, count);
      Images images(changes.rows(), frames.sensor().pixels());
      std::vector<FrameReport> reports(count);
      const Frames scaled = gain * changes;
      const Frames given = completes ? checked.completed(scaled, frames.kept_channels()) : scaled;
      solver->reconstruct(given, images, reports);
      images *= ratio;
      RowMajorMatrix status(changes.rows(), 1);
      RowMajorMatrix reason(changes.rows(), 1);
      for (Eigen::Index i = 0; i < changes.rows(); ++i) {
        FrameReport& report = reports[static_cast<std::size_t>(i)];
        judge(frames, first + static_cast<std::uint64_t>(i), changes.row(i), report, summary);
        if (!images.row(i).allFinite()) report.status = FrameStatus::undefined;
        if (report.status == FrameStatus::undefined) images.row(i).setConstant(std::nan(""));
        count_report(report, summary);
        status(i, 0) = static_cast<double>(report.status);
        reason(i, 0) = report.reasons;
        level(static_cast<Eigen::Index>(first) + i, 0) = report.level;
      }
      out.write_rows("/conductivity_change", first, images);
      out.write_rows("/status", first, status);
      out.write_rows("/reason", first, reason);
      if (const ContactFinder* finder = solver->contact_finder()) {
        RowMajorMatrix found = contacts_of(*finder, frames.sensor(), twins, given);
        for (Eigen::Index c = 3; c < found.cols(); c += contact_columns) found.col(c) *= ratio;
        out.write_rows("/contacts", first, found);
      }
      progress.update(first + count, frames.frames());
    }
    write_level(out, level);
    out.close();
  };
  replace_file(options.output, write, aside);
  return summary;
}

json to_json(const ReconstructSummary& s) {
  return {s.frames,      s.not_converged, s.undefined, s.suspect,
          s.with_reason, s.faults,        s.checked,   s.reference};
}

ReconstructSummary summary_from_json(const json& value) {
  return {value.at(0), value.at(1), value.at(2), value.at(3),
          value.at(4), value.at(5), value.at(6), value.at(7)};
}

constexpr std::uint64_t least_recorded = 10;
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

void require_image_output(const fs::path& output, const std::vector<fs::path>& inputs) {
  require_output(output, inputs,
                 {"file of images (/conductivity_change)", [](const fs::path& there) {
                    return Hdf5File::holds(there, "/conductivity_change");
                  }});
}

std::vector<fs::path> reconstruction_inputs(const std::string& solver, const fs::path& frames) {
  const NamedSolver named = read_named_solver(solver);
  std::vector<fs::path> inputs = {named.source, frames};
  if (named.entry->is_object() && named.entry->contains("checkpoint")) {
    JsonObject object(*named.entry, named.source, "");
    inputs.push_back(fitted_file(object.text("checkpoint"), object.folder()));
  }
  return inputs;
}

RowMajorMatrix contacts_of(const ContactFinder& finder, const Sensor& sensor,
                           const std::vector<Eigen::Matrix2d>& twins, const Frames& changes) {
  std::vector<std::vector<FoundContact>> found(static_cast<std::size_t>(changes.rows()));
  finder.find_contacts(changes, found);
  for (std::vector<FoundContact>& contacts : found) add_twins(sensor, twins, contacts);
  const double unit_mm = sensor.sheet->unit_mm();
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  RowMajorMatrix out =
      RowMajorMatrix::Constant(changes.rows(), most_written * contact_columns, std::nan(""));
  for (Eigen::Index f = 0; f < out.rows(); ++f) {
    const std::vector<FoundContact>& contacts = found[static_cast<std::size_t>(f)];
    const auto count = std::min(static_cast<Eigen::Index>(contacts.size()), most_written);
    for (Eigen::Index c = 0; c < count; ++c) {
      const FoundContact& contact = contacts[static_cast<std::size_t>(c)];
      const Eigen::Vector2d place = unit_mm * (contact.place - middle);
      const Eigen::Vector2d deviation = unit_mm * contact.place_deviation;
      out.row(f).segment<contact_columns>(c * contact_columns) << place.x(), place.y(),
          unit_mm * std::sqrt(contact.area / std::numbers::pi), contact.peak, deviation.x(),
          deviation.y();
    }
  }
  return out;
}

void survive_reading(const fs::path& path, const std::function<void()>& read) {
  inspected(path, [&]() -> json {
    try {
      read();
    } catch (const std::exception&) {
    }
    return nullptr;
  });
}

void read_frames(const OwnFramesOptions& options) {
  const OwnFrames frames(options);
  for (std::uint64_t first = 0; first < frames.frames(); first += streamed_frames) {
    frames.changes(first, std::min(streamed_frames, frames.frames() - first));
  }
}

void read_frames(const fs::path& input) {
  OwnFramesOptions options;
  options.input = input;
  read_frames(options);
}

ReconstructSummary reconstruct_file(const ReconstructOptions& options, SolverRegistry& registry) {
  const fs::path& output = options.output;
  require_image_output(output, reconstruction_inputs(options.solver, options.frames.input));
  survive_reading(options.frames.input, [&] { read_frames(options.frames); });
  const fs::path aside = aside_of(output);
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        registry.allow_plugins();
        json said;
        try {
          said["summary"] = to_json(reconstruct_here(options, aside, registry));
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
    throw InputError(options.solver + ": the solver ended its process (" + outcome.end.text() +
                     "); " + output.string() + " was not written");
  }
  const json said = parse_json(outcome.messages.back(), "what the solver's process said");
  if (said.contains("refused")) throw InputError(said.at("refused").get<std::string>());
  if (said.contains("no_memory")) throw std::bad_alloc();
  if (said.contains("failed")) {
    const std::runtime_error failed(said.at("failed").get<std::string>());
    blame_plugin(options.solver, options.plugin, failed);
    throw failed;
  }
  return summary_from_json(said.at("summary"));
}

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
  if (count < least_recorded || count > most_frames) {
    throw InputError(options.input.string() + ": noise is known from " +
                     std::to_string(least_recorded) + " to " + std::to_string(most_frames) +
                     " frames without contact, these are " + std::to_string(count) +
                     "; record more, or choose by --rows");
  }
  Frames voltages = frames.voltages(first, count);
  const QuietCheck quiet = check_quiet(frames.sensor(), voltages);
  if (!quiet.refused.empty() && (!force || quiet.unlike.empty())) {
    throw InputError(options.input.string() + ": " + quiet.refused + "; nothing was calibrated" +
                     (quiet.unlike.empty() ? ""
                                           : ": choose others by --rows, or --force leaves "
                                             "them out"));
  }
  CalibrationOutcome outcome;
  const Eigen::VectorXd usual = median_of_rows(voltages).transpose();
  outcome.verdict = check_reference(frames.sensor(), usual, {});
  ReferenceVerdict& verdict = outcome.verdict;
  using State = ReferenceVerdict::State;
  // A wrong level alone is accepted: the calibration measures it.
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
  std::vector<Eigen::Index> kept;
  for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
    if (!std::binary_search(quiet.unlike.begin(), quiet.unlike.end(), f)) kept.push_back(f);
  }
  if (kept.size() < least_recorded) {
    throw InputError(options.input.string() + ": only " + std::to_string(kept.size()) +
                     " frames are alike; record " + std::to_string(least_recorded) + " or more");
  }
  outcome.calibration = calibrate(frames.sensor(), voltages(kept, Eigen::all));
  outcome.calibration.declared = frames.declared_sensor();
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
