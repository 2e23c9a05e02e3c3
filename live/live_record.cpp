#include "live/live_record.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "frames/frame_source.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
namespace layout = dataset_layout;

/// Rows in the queue: some 12 MB with answers of 24 x 24 pixels.
constexpr std::size_t most_waiting_rows = 4096;
constexpr std::uint64_t copied_rows = 1024;
constexpr Eigen::Index answer_columns = 6;  ///< before the image
constexpr std::uint64_t recorded_contact_columns = 6;
constexpr const char* recorded_numbers = "/frame_number";

double or_nan(std::optional<double> value) {
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

LiveRecord::LiveRecord(fs::path file, const std::vector<fs::path>& inputs, const Sensor& sensor)
    : file_(std::move(file)), sensor_(sensor) {
  require_output(file_, inputs, {"record of a stream (/frame_number)", [](const fs::path& there) {
                                   return Hdf5File::holds(there, recorded_numbers);
                                 }});
  width_[frames] = 2 + static_cast<std::uint64_t>(sensor.channels());
  width_[answers] = answer_columns + static_cast<std::uint64_t>(sensor.pixels());
  width_[contacts] = recorded_contact_columns;
  const char* const names[] = {".frames", ".answers", ".contacts"};
  for (std::size_t p = 0; p < parts; ++p) {
    raw_[p] = aside_of(file_);
    raw_[p] += names[p];
    streams_[p].rdbuf()->pubsetbuf(nullptr, 0);  // a crash loses no row that was written
    streams_[p].open(raw_[p], std::ios::binary | std::ios::trunc);
    if (!streams_[p]) {
      throw InputError("--record: " + raw_[p].string() +
                       " cannot be written; name a file in a folder that can");
    }
  }
  writer_ = std::thread([this] { write_rows(); });
}

LiveRecord::~LiveRecord() {
  if (writer_.joinable()) end_writer();
  for (std::size_t p = 0; p < parts; ++p) {
    std::error_code ignored;
    if (p != frames || !frames_stay_) fs::remove(raw_[p], ignored);
  }
}

void LiveRecord::end_writer() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  writer_.join();
}

void LiveRecord::put(std::vector<Row> rows) {
  {
    const std::lock_guard lock(mutex_);
    if (queue_.size() + rows.size() > most_waiting_rows) {
      not_kept_ += rows.size();
      return;
    }
    for (Row& row : rows) queue_.push_back(std::move(row));
  }
  changed_.notify_all();
}

void LiveRecord::came(const ArrivedFrame& frame, double time_s) {
  Row row{frames, {static_cast<double>(frame.number), time_s}};
  row.values.insert(row.values.end(), frame.voltages.begin(), frame.voltages.end());
  std::vector<Row> rows;
  rows.push_back(std::move(row));
  put(std::move(rows));
}

void LiveRecord::answered(std::uint64_t frame, double latency_s, const LiveAnswer& answer) {
  const auto alarm = answer.alarm ? std::optional(*answer.alarm ? 1.0 : 0.0) : std::nullopt;
  Row row{answers,
          {static_cast<double>(frame), latency_s, static_cast<double>(answer.report.status),
           static_cast<double>(answer.report.reasons), or_nan(answer.force_N), or_nan(alarm)}};
  row.values.insert(row.values.end(), answer.image.row(0).begin(), answer.image.row(0).end());
  std::vector<Row> rows;
  rows.push_back(std::move(row));
  for (const ContactReading& one : answer.reading.contacts) {
    rows.push_back(
        {contacts, {0, one.place_mm.x(), one.place_mm.y(), one.strength, one.peak, one.area_mm2}});
  }
  put(std::move(rows));
}

void LiveRecord::write_rows() {
  bool answer_is_kept = false;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return over_ || !queue_.empty(); });
    if (queue_.empty()) return;
    Row row = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    if (row.part == contacts) row.values[0] = static_cast<double>(rows_of(answers)) - 1;
    if (row.part != contacts || answer_is_kept) {
      const bool kept = write(row);
      if (row.part == answers) answer_is_kept = kept;
    }
    lock.lock();
  }
}

bool LiveRecord::write(const Row& row) {
  std::ofstream& stream = streams_[row.part];
  const auto bytes = static_cast<std::streamsize>(row.values.size() * sizeof(double));
  if (stream.write(reinterpret_cast<const char*>(row.values.data()), bytes)) {
    written_[row.part] += row.values.size();
    return true;
  }
  ++not_kept_;
  if (!std::exchange(refused_, true)) {
    spdlog::warn("--record: the disk refuses rows, which are not kept; make room");
  }
  // The next row overwrites the part of this one that was written.
  stream.clear();
  stream.seekp(static_cast<std::streamoff>(written_[row.part] * sizeof(double)));
  return false;
}

void LiveRecord::copy(Part part,
                      const std::function<void(std::uint64_t, const RowMajorMatrix&)>& take) const {
  std::ifstream in(raw_[part], std::ios::binary);
  const std::uint64_t rows = rows_of(part);
  for (std::uint64_t first = 0; first < rows; first += copied_rows) {
    const std::uint64_t count = std::min(copied_rows, rows - first);
    RowMajorMatrix block(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(width_[part]));
    in.read(reinterpret_cast<char*>(block.data()),
            static_cast<std::streamsize>(sizeof(double) * count * width_[part]));
    if (!in) throw InputError(raw_[part].string() + ": cannot be read back; is the disk full?");
    take(first, block);
  }
}

bool LiveRecord::finish(const Eigen::RowVectorXd& reference, const std::string& solver) {
  end_writer();
  for (std::ofstream& stream : streams_) {
    stream.close();
    refused_ |= stream.fail();
  }
  if (rows_of(frames) == 0) {
    if (refused_) {
      throw InputError(file_.string() + ": not written, as the disk refused it; make room");
    }
    return false;
  }
  try {
    replace_file(file_, [&](const fs::path& place) { write_file(place, reference, solver); });
  } catch (const std::exception& error) {
    frames_stay_ = true;
    throw InputError(file_.string() + ": cannot be written (" + error.what() +
                     "); what came stays as rows of " + std::to_string(width_[frames]) +
                     " doubles in " + raw_[frames].string() +
                     ": the frame's number, its time in s, its voltages");
  }
  if (refused_) {
    throw InputError(file_.string() + ": is not whole, as the disk refused some of it; make room");
  }
  return true;
}

void LiveRecord::write_file(const fs::path& place, const Eigen::RowVectorXd& reference,
                            const std::string& solver) const {
  const std::uint64_t came = rows_of(frames);
  const std::uint64_t answered = rows_of(answers);
  Hdf5File out = Hdf5File::create(place);
  out.write_text("/", "sensor", json_text(to_json(sensor_)));
  out.write_text("/", "solver", solver);
  out.write_number("/", "not_kept", static_cast<double>(not_kept_));
  if (reference.size() > 0) {
    out.write_vector(dataset_layout::reference_voltages, reference.transpose());
  }
  const auto channels = static_cast<std::uint64_t>(sensor_.channels());
  out.create_dataset(dataset_layout::voltages, {came, channels});
  out.create_dataset(dataset_layout::time, {came});
  out.create_dataset(recorded_numbers, {came});
  copy(frames, [&](std::uint64_t first, const RowMajorMatrix& rows) {
    out.write_rows(recorded_numbers, first, rows.leftCols(1));
    out.write_rows(dataset_layout::time, first, rows.col(1));
    out.write_rows(dataset_layout::voltages, first, rows.rightCols(sensor_.channels()));
  });
  if (answered > 0) {
    const auto image_rows = static_cast<std::uint64_t>(sensor_.image_rows());
    const auto image_columns = static_cast<std::uint64_t>(sensor_.image_columns());
    const char* const columns[answer_columns] = {"/answer/frame",  "/answer/latency",
                                                 "/answer/status", "/answer/reason",
                                                 "/answer/force",  "/answer/alarm"};
    for (const char* column : columns) out.create_dataset(column, {answered});
    out.create_dataset("/answer/conductivity_change", {answered, image_rows, image_columns});
    copy(answers, [&](std::uint64_t first, const RowMajorMatrix& rows) {
      for (Eigen::Index c = 0; c < answer_columns; ++c) {
        out.write_rows(columns[c], first, rows.col(c));
      }
      out.write_rows("/answer/conductivity_change", first, rows.rightCols(sensor_.pixels()));
    });
  }
  if (rows_of(contacts) > 0) {
    out.create_dataset("/answer/contacts", {rows_of(contacts), width_[contacts]});
    copy(contacts, [&](std::uint64_t first, const RowMajorMatrix& rows) {
      out.write_rows("/answer/contacts", first, rows);
    });
  }
  out.close();
}

void FramesOfFile::require(const Sensor& expected, const std::string& file,
                           Eigen::Index columns) const {
  if (sensor && !(*sensor == expected)) {
    throw InputError(file + ": its frames are of another sensor than the solver's");
  }
  const Eigen::Index channels =
      voltages.size() == 0 && reference ? reference->size() : voltages.cols();
  if (columns == 0) columns = expected.channels();
  if (channels != columns) {
    throw InputError(file + ": its frames have " + std::to_string(channels) +
                     " channels, those of the solver's sensor " + std::to_string(columns) +
                     "; name theirs by --sensor");
  }
}

FramesOfFile read_frames_of(const std::string& name, const std::string& option) {
  if (name.empty()) throw InputError(option + ": names no file");
  FramesOfFile out;
  if (std::filesystem::exists(name) && !is_hdf5_file(name)) {
    out.source = open_frames(name, {});
    out.voltages = out.source->read(0, out.source->frames());
    out.sensor = out.source->sensor();
    if (const RowMajorMatrix rows = out.source->reference(); rows.rows() == 1) {
      out.reference = rows.row(0);
    }
    return out;
  }
  const Hdf5File file = Hdf5File::open(name);
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

QuietFrames read_quiet(const std::string& text, const Sensor& sensor, const ChannelMap& map) {
  const std::string name = quiet_file(text);
  double rate = 0;
  if (const auto at = text.rfind('@'); at != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + at + 1, end, rate);
    if (read.ec != std::errc() || read.ptr != end || !(rate > 0 && std::isfinite(rate))) {
      throw InputError("--quiet: must be FILE.h5 or FILE.h5@RATE, got \"" + printable(text) + "\"");
    }
  }
  FramesOfFile frames = read_frames_of(name, "--quiet");
  if (!frames.reference) throw InputError(name + ": has no /reference_voltages [channels] V");
  frames.require(sensor, name, frames.sensor ? 0 : map.columns);
  if (!frames.voltages.allFinite()) throw InputError(name + ": /voltages: must be finite");
  if (!frames.sensor) {
    frames.voltages = map.apply(frames.voltages);
    frames.reference = map.apply(*frames.reference);
  }
  QuietFrames out;
  out.changes = frames.voltages.rowwise() - *frames.reference;
  out.reference = *frames.reference;
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
  out.reference = file.reference_voltages().transpose();
  out.changes.resize(std::ssize(rows), voltages.cols());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    out.changes.row(static_cast<Eigen::Index>(r)) = voltages.row(rows[r]) - out.reference;
  }
  return out;
}

}  // namespace ertbench
