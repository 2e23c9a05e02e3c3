#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/studies/alarm_thresholds.h"
#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "frames/channels.h"
#include "live/line_output.h"
#include "live/live_solver.h"

namespace ertbench {

/// Records frames and answers. While the stream runs, rows are appended to raw files beside the
/// record; `finish` turns them into the HDF5 file, by atomic rename:
///
///     /voltages [N, channels] V, /time [N] s since the beginning, /frame_number [N]: every usable
///     frame
///     /reference_voltages [channels] V and attribute "sensor", so that the file can be replayed
///     /answer/frame [M] its number, /answer/latency [M] s from arrival to answer,
///     /answer/conductivity_change [M, grid, grid] S/m, /answer/status, /answer/reason [M],
///     /answer/force [M] N and /answer/alarm [M], NaN if there is none
///     /answer/contacts [K, 6]: row of /answer, x and y in mm, strength, peak, area in mm²
///
/// A separate thread writes, so that a slow disk costs no frame; rows beyond its queue are dropped
/// and counted. All functions but `finish` may be called from any thread.
class LiveRecord {
 public:
  /// Throws InputError if the file must not be overwritten: it is no record of a stream, or one of
  /// the stream's `inputs`.
  LiveRecord(std::filesystem::path file, const std::vector<std::filesystem::path>& inputs,
             const Sensor& sensor);
  LiveRecord(const LiveRecord&) = delete;
  LiveRecord& operator=(const LiveRecord&) = delete;
  ~LiveRecord();  ///< discards the rows if `finish` was not called

  void came(const ArrivedFrame& frame, double time_s);
  void answered(std::uint64_t frame, double latency_s, const LiveAnswer& answer);

  /// Writes the file and returns true; returns false, without a file, if there was no frame. Throws
  /// InputError if the disk refuses it; the raw file of the frames is kept then, and the message
  /// describes its format.
  bool finish(const Eigen::RowVectorXd& reference, const std::string& solver);
  /// Number of rows dropped because the queue or the disk was full.
  std::uint64_t not_kept() const { return not_kept_; }

 private:
  enum Part : std::size_t { frames, answers, contacts, parts };
  struct Row {
    Part part;
    std::vector<double> values;
  };

  void put(std::vector<Row> rows);
  void write_rows();
  void end_writer();  ///< once it has written what waits
  bool write(const Row& row);
  void write_file(const std::filesystem::path& place, const Eigen::RowVectorXd& reference,
                  const std::string& solver) const;
  std::uint64_t rows_of(Part part) const { return written_[part] / width_[part]; }
  void copy(Part part, const std::function<void(std::uint64_t, const RowMajorMatrix&)>& take) const;

  std::filesystem::path file_;
  Sensor sensor_;
  std::filesystem::path raw_[parts];
  std::ofstream streams_[parts];
  std::uint64_t width_[parts];      ///< numbers in a row
  std::uint64_t written_[parts]{};  ///< numbers
  std::atomic<std::uint64_t> not_kept_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Row> queue_;
  bool over_ = false;
  bool refused_ = false;  ///< the disk, some row
  bool frames_stay_ = false;
  std::thread writer_;
};

// Input files of a stream. All functions throw InputError naming file and remedy; `option` is the
// command-line option that names the file.

/// `/voltages` of a file with its optional companions.
struct FramesOfFile {
  Frames voltages;  ///< [frames, channels] V; may hold values that are not finite
  std::optional<Eigen::RowVectorXd> reference;
  std::vector<double> times_s;   ///< [frames] `/time`; empty if the file has none
  std::optional<Sensor> sensor;  ///< attribute "sensor"; files of instruments have none
  std::shared_ptr<const FrameSource> source;  ///< of files that are no HDF5, which it has read

  /// Throws InputError, naming `file`, if the sensor or the number of columns does not fit; without
  /// `columns` it is that of the sensor's channels.
  void require(const Sensor& expected, const std::string& file, Eigen::Index columns = 0) const;
};
FramesOfFile read_frames_of(const std::string& file, const std::string& option);

/// Frames without contact.
struct QuietFrames {
  Frames changes;                ///< [frames, channels] V from the file's reference
  Eigen::RowVectorXd reference;  ///< [channels] V
  FrameRuns runs;
};
/// `text` is FILE or FILE@RATE; without a rate it follows from `/time`. A run begins wherever the
/// time goes back. Files that name a sensor are in its order and in V, others as `map` says.
QuietFrames read_quiet(const std::string& text, const Sensor& sensor, const ChannelMap& map);
/// Returns FILE of such a text.
std::string quiet_file(const std::string& text);

/// Frames of a dataset with a single touch of known force; the others are left out.
struct ForceFrames {
  Frames changes;
  Eigen::RowVectorXd reference;
  std::vector<double> forces_N;
};
ForceFrames read_forces(const std::string& file, const Sensor& sensor);

}  // namespace ertbench
