#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frames/channels.h"
#include "live/line_output.h"
#include "live/live_solver.h"
#include "live/live_source.h"
#include "live/live_state.h"

namespace ertbench {

class SolverRegistry;

/// Options of `ertbench live`.
struct LiveOptions {
  /// File of one entry of "solvers" or name of a stored solver (read_named_solver); with
  /// `experiment` a label in it.
  std::string solver;
  std::string experiment;       ///< may be empty
  std::string plugin;           ///< library of the user's own solvers; may be empty
  std::optional<double> floor;  ///< least change of a contact, S/m; nothing: the experiment's
  std::string sensor;  ///< JSON file; empty: the experiment's, the replayed file's or the default
  std::string input = "-";
  std::string channels;     ///< order of the sender's columns (channel_map)
  std::string unit;         ///< the sender's: "V", "mV" or "uV"
  bool fix = false;         ///< mend the frames as check_reference proposes
  bool normalised = false;  ///< changes relative to the reference, times the model's voltages
  bool force = false;       ///< image the frames whatever it finds
  FrameFormat format = FrameFormat::detect;
  std::string reference;  ///< HDF5 file, or "model"; empty: the replayed file's
  int background = 0;     ///< number of first frames whose mean is the reference; 0: none
  bool follow = false;    ///< QuietReference
  std::string quiet;      ///< HDF5 file of frames without contact, FILE[@RATE]
  double false_alarms_per_hour = 10;
  std::string forces;  ///< dataset of single touches with known forces
  int repeat = 1;      ///< number of times a file is replayed
  std::size_t places = 1;
  bool lossless = false;
  double silence_s = 2;
  double deadline_s = 0;  ///< 0: none
  std::string http;       ///< HOST:PORT; empty: no page
  int http_clients = 4;
  std::string record;  ///< empty: none
  bool images = false;
  std::string send;          ///< udp://HOST:PORT that gets each answer; empty: nobody
  bool send_binary = false;  ///< as binary_record, not as the line of JSON
  int threads = 1;           ///< while the solver is fitted
};

/// Everything that a stream needs before its first frame.
struct LiveSetup {
  std::string solver_name;  ///< label or type
  std::string parameters;   ///< the solver's, JSON
  std::unique_ptr<LiveSolver> solver;
  /// Fits a solver that takes its noise from the first frames: from their mean [channels] V, after
  /// mending, and their noise relative to its root mean square. Empty: `solver` is ready.
  std::function<std::shared_ptr<Solver>(const Eigen::VectorXd& reference, double noise)> fit;
  std::unique_ptr<LiveSource> source;
  ChannelMap map;                            ///< from the sender's columns to channels in V
  bool checked = true;                       ///< frames are checked for noise and range
  std::vector<std::filesystem::path> files;  ///< its inputs, which must not be overwritten
};

/// Sets the reference [channels] V and compares it with the model of the sensor, as `reconstruct`
/// does: mends the frames if the options say so, warns of what is odd, or throws InputError.
void take_reference(LiveSolver& solver, const Eigen::RowVectorXd& reference,
                    const LiveOptions& options);

/// Reads, fits and opens all of it. A solver of an experiment comes from the cache, or is fitted
/// and cached; a solver file has a "checkpoint" or its type needs no data, as for `reconstruct`.
/// Loads plugins into this process. Throws InputError.
LiveSetup live_setup(const LiveOptions& options, SolverRegistry& registry);

/// How a stream went.
struct LiveSummary {
  LiveCounts counts;
  LatencyHistogram latency;  ///< from arrival to answer
  double seconds = 0;
  std::string why;  ///< the reason why it ended
};

/// Images a stream of frames until it ends, a signal (SIGINT, SIGTERM, SIGHUP) arrives or standard
/// output is closed. Writes a line of JSON for each answered frame,
///
///     {"frame", "time_s", "latency_us", "solver_us", "dropped", ... and the keys of answer_json}
///
/// and lines {"event": ...}: "begin", "background" (the reference is known), "damaged" (at most one
/// a second), "silence" and "resumed" (the sender's), "end". A frame's latency is the time from its
/// arrival to its answer, waiting included. One thread reads, the caller's thread images and the
/// page has its own threads. Throws InputError for unusable input, also if a device disappears; the
/// record is completed first.
LiveSummary run_live(const LiveOptions& options, SolverRegistry& registry);

}  // namespace ertbench
