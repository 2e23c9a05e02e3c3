#include "forward/data/generate.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "forward/data/data_probes.h"
#include "forward/data/dataset_file.h"
#include "forward/data/measured_file.h"
#include "forward/data/scene_model.h"

namespace ertbench {

std::string MissedPromise::sentence() const {
  if (scenes == 0) return "";
  char text[256];
  std::snprintf(text, sizeof text,
                "%llu of %llu scenes %s voltages whose estimated error is above %g of the noise%s, "
                "at most %.2g V",
                static_cast<unsigned long long>(scenes), static_cast<unsigned long long>(of),
                scenes == 1 ? "has" : "have", model_error, is_noisy ? "" : " of 80 dB",
                largest_error);
  return text;
}

MissedPromise missed_promise(const DatasetSpec& spec, const DatasetFile& file) {
  constexpr std::uint64_t rows_at_once = 4096;
  constexpr double rounding = 1 + 1e-9;
  MissedPromise out{.of = file.size(),
                    .model_error = model_error_of(spec.model),
                    .is_noisy = spec.noise.snr_db.has_value()};
  for (std::uint64_t first = 0; first < file.size(); first += rows_at_once) {
    const std::uint64_t count = std::min(rows_at_once, file.size() - first);
    const Eigen::VectorXd errors = file.model_errors(first, count);
    if (errors.size() == 0) break;
    const Frames clean = file.clean_voltages(first, count);
    for (Eigen::Index i = 0; i < errors.size(); ++i) {
      const double allowed =
          out.model_error * noise_norm(spec.noise, file.reference_voltages(), clean.row(i));
      if (errors[i] <= rounding * allowed) continue;
      ++out.scenes;
      out.largest_error = std::max(out.largest_error, errors[i]);
    }
  }
  return out;
}

namespace {

namespace fs = std::filesystem;
namespace layout = dataset_layout;

constexpr std::uint64_t rows_per_block = 1024;

/// The name under which a dataset grows.
fs::path part_of(const fs::path& file) {
  fs::path part = file;
  return part += ".part";
}

/// True if it begins like an HDF5 file and cannot be opened as one.
bool is_unfinished_hdf5(const fs::path& file) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  std::array<char, signature.size()> start{};
  std::ifstream(file, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == signature && !Hdf5File::holds(file, "/");
}

std::uint64_t bytes_of(const DatasetSpec& spec) {
  const auto channels = static_cast<std::uint64_t>(spec.sensor.channels());
  const auto pixels = static_cast<std::uint64_t>(spec.sensor.pixels());
  return 8 * spec.count *
         (2 * channels + pixels + layout::contact_width(spec) * (8 + 2 * spec.most_vertices()) +
          layout::effort_columns_of(spec) + 2);
}

/// Source of a set's frames: the model of its sheet, or a file.
class FrameSource {
 public:
  explicit FrameSource(const DatasetSpec& spec) : spec_(spec) {
    if (spec.measured()) {
      measured_.emplace(spec);
    } else {
      model_.emplace(spec.sensor, spec.model);
    }
  }

  Eigen::VectorXd reference() const {
    return measured_ ? measured_->reference_voltages()
                     : recorded_reference(spec_.faults, model_->reference_voltages());
  }
  DatasetBlock block(std::uint64_t first, std::uint64_t count, int threads) const {
    return measured_ ? measured_->block(first, count)
                     : generate_block(spec_, *model_, first, count, threads);
  }

 private:
  const DatasetSpec& spec_;
  std::optional<SceneModel> model_;
  std::optional<MeasuredBlocks> measured_;
};

/// Creates the unfinished file with all its storage reserved.
void create_part(const DatasetSpec& spec, const FrameSource& source, const fs::path& part) {
  std::error_code error;
  const fs::path folder = part.has_parent_path() ? part.parent_path() : fs::path(".");
  const fs::space_info space = fs::space(folder, error);
  const std::uint64_t needed = bytes_of(spec) + (1u << 20);
  if (!error && space.available < needed) {
    throw InputError(part.string() + ": needs " + std::to_string(needed >> 20) +
                     " MB of disk, only " + std::to_string(space.available >> 20) +
                     " MB are free; lower the count or write elsewhere");
  }
  Hdf5File file = Hdf5File::create(part);
  const auto channels = static_cast<std::uint64_t>(spec.sensor.channels());
  const auto rows = static_cast<std::uint64_t>(spec.sensor.image_rows());
  const auto columns = static_cast<std::uint64_t>(spec.sensor.image_columns());
  const auto describe = [&](const std::string& dataset, const std::string& unit,
                            const char* meaning) {
    file.write_text(dataset, "units", unit);
    file.write_text(dataset, "description", meaning);
  };
  const auto add = [&](const std::string& dataset, const std::vector<std::uint64_t>& shape,
                       const std::string& unit, const char* meaning) {
    file.create_dataset(dataset, shape);
    describe(dataset, unit, meaning);
  };
  add(layout::voltages, {spec.count, channels}, "V",
      "measured frames, with noise; where each had a reference of its own, moved to "
      "/reference_voltages, the mean of these");
  add(layout::clean_voltages, {spec.count, channels}, "V", "the same frames without noise");
  add(layout::conductivity, {spec.count, rows, columns}, "S/m",
      spec.sensor.sheet->name() == "square"
          ? "true images [scene, row, column]: row 0 at y = -1, column 0 at x = -1"
          : "true images [scene, row, column]: row 0 at the least y, column 0 at the least x");
  add(layout::contacts, {spec.count, layout::contact_width(spec), layout::contact_columns},
      "domain units (sheet " + spec.sensor.sheet->extent() + "), rad, 1",
      "columns: kind (0 disc, 1 ellipse, 2 rectangle, 3 polygon), centre x, centre y, size a, "
      "size b, angle, conductivity ratio; NaN rows are absent");
  if (spec.most_vertices() > 0) {
    add(layout::contact_vertices,
        {spec.count, layout::contact_width(spec), spec.most_vertices(), 2}, "domain units",
        "[scene, contact, vertex, (x, y)] of polygons; NaN where absent");
  }
  if (spec.has_touches()) {
    add(layout::forces, {spec.count, layout::contact_width(spec)}, "N",
        "force of each contact; NaN where absent");
  }
  if (const SequenceSet* set = spec.sequences()) {
    add(layout::time, {spec.count}, "s",
        "middle of the frame, for which the truth is given, since the beginning of its "
        "sequence");
    add(layout::sequence, {spec.count}, "1", "number of the frame's sequence, from 0");
    file.write_number("/", "frame_rate_hz", set->timing().frame_rate);
    file.write_number("/", "drive_time_s", set->timing().drive_time_s);
  }
  if (layout::effort_columns_of(spec) > 0) {
    add(layout::model_effort, {spec.count, layout::effort_columns}, "1, V",
        "points of the scene's border integral equation; estimated 2-norm of the error of its "
        "clean voltages");
  }
  file.write_vector(layout::reference_voltages, source.reference());
  describe(layout::reference_voltages, "V",
           spec.measured() ? "the untouched sheet, as measured"
                           : "the untouched sheet by the same model, without noise");
  if (const MeasuredFrames* measured = spec.measured()) {
    const Truth& truth = measured->truth;
    std::string known = truth.images || truth.places ? "" : "nothing";
    if (truth.images) known += "images ";
    if (truth.places) known += "places";
    file.write_text("/", layout::truth, known);
  }
  file.write_vector(layout::scenes_written, Eigen::VectorXd::Zero(1));
  file.write_number("/", "schema_version", layout::schema_version);
  file.write_text_dataset(layout::recipe, to_json(spec).dump());
  file.write_text("/", "build", to_json(stamp_of_this_build(data_probes(spec))).dump());
  file.write_text("/", "sensor", to_json(spec.sensor).dump());
  file.write_number("/", "seed", static_cast<double>(spec.seed));
  file.write_number("/", "snr_db", spec.noise.snr_db.value_or(INFINITY));
  file.write_text("/", "snr_basis", name_of(spec.noise.basis));
  file.write_text("/", "channel_order",
                  "for drive k = 0 ... L-1 (-I at electrode k, +I at k+1): for pair j = 0 ... L-1 "
                  "ascending, V_j - V_(j+1), pairs sharing an electrode with the drive skipped");
  file.write_text("/", "electrode_order",
                  "clockwise along the border from " + spec.sensor.sheet->border_start());
  file.close();
}

/// Number of complete scenes of an earlier call in `part`; no value if it cannot be continued.
std::optional<std::uint64_t> resumable(const DatasetSpec& spec, const fs::path& part) {
  if (!fs::exists(part)) return std::nullopt;
  try {
    const Hdf5File file = Hdf5File::open(part);
    if (written_recipe(file) != to_json(spec).dump()) return std::nullopt;
    const std::optional<BuildStamp> build = written_build(file);
    if (!build || !probe_difference(build->probes, data_probes(spec)).empty()) return std::nullopt;
    const double written = file.read_rows(layout::scenes_written, 0, 1)(0, 0);
    if (!(written >= 0 && written <= static_cast<double>(spec.count))) return std::nullopt;
    return static_cast<std::uint64_t>(written);
  } catch (const InputError&) {
    return std::nullopt;  // cut off before its storage was reserved, or no dataset at all
  }
}

/// True if `file` is a complete dataset of this spec that this program would write alike.
bool is_finished(const DatasetSpec& spec, const fs::path& file) {
  if (!fs::exists(file)) return false;
  try {
    const DatasetFile set(file);
    return set.recipe() == to_json(spec).dump() && set.build() &&
           probe_difference(set.build()->probes, data_probes(spec)).empty() &&
           set.why_changed().empty();
  } catch (const InputError&) {
    return false;
  }
}

/// Removes an unfinished file without a complete scene.
void remove_part(const fs::path& part) {
  std::error_code ignored;
  fs::remove(part, ignored);
}

/// Computes and writes the scenes from `whole` on; `whole` counts those that are safely in the
/// file.
void write_scenes(const DatasetSpec& spec, const FrameSource& source, const fs::path& part,
                  const GenerateOptions& options, std::uint64_t& whole) {
  const int threads = std::max(1, options.threads);
  Hdf5File out = Hdf5File::open_writable(part);
  const auto block_at = [&](std::uint64_t first) {
    const std::uint64_t count = std::min(rows_per_block, spec.count - first);
    return std::async(std::launch::async,
                      [&, first, count] { return source.block(first, count, threads); });
  };
  std::future<DatasetBlock> next;
  if (whole < spec.count) next = block_at(whole);
  while (whole < spec.count) {
    const DatasetBlock block = next.get();
    const std::uint64_t first = whole;
    const std::uint64_t done = first + static_cast<std::uint64_t>(block.voltages.rows());
    if (done < spec.count) next = block_at(done);  // computed while this one is written
    out.write_rows(layout::voltages, first, block.voltages);
    out.write_rows(layout::clean_voltages, first, block.clean_voltages);
    out.write_rows(layout::conductivity, first, block.conductivity);
    out.write_rows(layout::contacts, first, block.contacts);
    if (block.effort.cols() > 0) out.write_rows(layout::model_effort, first, block.effort);
    if (block.vertices.cols() > 0) out.write_rows(layout::contact_vertices, first, block.vertices);
    if (block.forces.cols() > 0) out.write_rows(layout::forces, first, block.forces);
    if (block.moments.cols() > 0) {
      out.write_rows(layout::time, first, block.moments.col(0));
      out.write_rows(layout::sequence, first, block.moments.col(1));
    }
    out.flush();
    out.write_rows(layout::scenes_written, 0,
                   RowMajorMatrix::Constant(1, 1, static_cast<double>(done)));
    out.flush();
    whole = done;
    if (options.progress) options.progress(whole, spec.count);
  }
  out.write_checksum();
  out.close();
}

}  // namespace

void require_dataset_output(const fs::path& file, const std::vector<fs::path>& inputs) {
  const auto is_dataset = [](const fs::path& one) {
    return Hdf5File::holds(one, layout::voltages) && Hdf5File::holds(one, layout::scenes_written);
  };
  require_output(file, inputs, {"dataset of ours", is_dataset});
  const auto is_part = [&](const fs::path& one) {
    // A file that was cut off before its storage was reserved is no dataset yet.
    return fs::is_empty(one) || is_dataset(one) || is_unfinished_hdf5(one);
  };
  require_output(part_of(file), inputs, {"unfinished dataset of ours", is_part});
}

void generate_dataset(const DatasetSpec& spec, const fs::path& file,
                      const GenerateOptions& options) {
  const FrameSource source(spec);
  const fs::path part = part_of(file);
  const FileLock lock(part);
  if (is_finished(spec, file)) {  // earlier, or by the last holder of the lock
    fs::remove(part);
    return;
  }
  std::uint64_t whole = 0;
  try {
    if (const auto found = resumable(spec, part)) {
      whole = *found;
    } else {
      create_part(spec, source, part);
    }
    write_scenes(spec, source, part, options, whole);
    lock.sync();
    std::error_code error;
    fs::rename(part, file, error);
    if (error) throw InputError(file.string() + ": cannot be put in place: " + error.message());
  } catch (const InputError& error) {
    if (whole > 0) {
      throw InputError(std::string(error.what()) + "; the same command goes on behind scene " +
                       std::to_string(whole));
    }
    remove_part(part);
    throw;
  } catch (...) {
    if (whole == 0) remove_part(part);
    throw;
  }
}

}  // namespace ertbench
