#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/studies/alarm_thresholds.h"
#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "live/line_output.h"
#include "live/live_solver.h"

namespace ertbench {

/// Keeps what came and what was answered. While the stream runs, rows grow in raw files beside the
/// record; `finish` makes the HDF5 file of them, writes it aside and renames it:
///
///     /voltages [N, channels] V, /time [N] s since the beginning, /frame_number [N]: every usable
///     frame that came
///     /reference_voltages [channels] V; attribute "sensor": so that the file can be imaged again
///     /answer/frame [M] its number, /answer/latency [M] s from arrival to answer,
///     /answer/conductivity_change [M, grid, grid] S/m, /answer/status, /answer/reason [M],
///     /answer/force [M] N and /answer/alarm [M], not a number where there is none
///     /answer/contacts [K, 6]: row of /answer, x and y in mm, strength, peak, area in mm²
///
/// A thread of its own writes, so that a slow disk costs no frame; what does not fit into its queue
/// is not kept, and counted. All functions may be called from any thread but `finish`.
class LiveRecord {
 public:
  /// Throws InputError where the file may not be written: something else stands there, or one of
  /// the `inputs` of the stream.
  LiveRecord(std::filesystem::path file, const std::vector<std::filesystem::path>& inputs,
             const Sensor& sensor);
  LiveRecord(const LiveRecord&) = delete;
  LiveRecord& operator=(const LiveRecord&) = delete;
  ~LiveRecord();  ///< forgets all where `finish` was not called

  void came(const ArrivedFrame& frame, double time_s);
  void answered(std::uint64_t frame, double latency_s, const LiveAnswer& answer);

  /// Writes the file and returns whether there was any frame; without one there is no file. Throws
  /// InputError where the disk refuses it; the raw file of the frames stays then, and the message
  /// says how it is read.
  bool finish(const Eigen::RowVectorXd& reference, const std::string& solver);
  /// Rows that found no place in the queue, or none on the disk.
  std::uint64_t not_kept() const { return not_kept_; }

 private:
  enum Part : std::size_t { frames, answers, contacts, parts };
  struct Row {
    Part part;
    std::vector<double> values;
  };

  void put(std::vector<Row> rows);
  void write_rows();
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

// Files that a stream is made ready with. All functions throw InputError naming file and remedy;
// `option` is what the user named the file with.

/// `/voltages`, and what belongs to it where it is there.
struct FramesOfFile {
  Frames voltages;  ///< [frames, channels] V; may hold values that are not finite
  std::optional<Eigen::RowVectorXd> reference;
  std::vector<double> times_s;  ///< [frames] `/time`; empty where there is none
  /// Attribute "sensor"; nothing where the file does not say, as those of instruments do not.
  std::optional<Sensor> sensor;

  /// Throws InputError, naming `file`, unless its frames may be those of `expected`.
  void require(const Sensor& expected, const std::string& file) const;
};
FramesOfFile read_frames_of(const std::string& file, const std::string& option);

/// Frames in which nothing touches.
struct QuietFrames {
  Frames changes;  ///< V, from their own reference
  FrameRuns runs;
};
/// `text` is FILE or FILE@RATE; without a rate `/time` tells it. Runs begin where the time goes
/// back.
QuietFrames read_quiet(const std::string& text, const Sensor& sensor);
/// FILE of such a text.
std::string quiet_file(const std::string& text);

/// Frames of a dataset in which one touch of known force is the only one; the others are left out.
struct ForceFrames {
  Frames changes;
  std::vector<double> forces_N;
};
ForceFrames read_forces(const std::string& file, const Sensor& sensor);

}  // namespace ertbench
