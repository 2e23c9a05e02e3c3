#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "live/live_solver.h"
#include "live/live_source.h"

namespace ertbench {

class SolverRegistry;

/// What `ertbench live` is asked for.
struct LiveOptions {
  std::string solver;           ///< file of one entry of "solvers"; with `experiment` a label in it
  std::string experiment;       ///< may be empty
  std::string plugin;           ///< library of the user's own solvers; may be empty
  std::optional<double> floor;  ///< least change of a contact, S/m; nothing: by the experiment
  std::string sensor;  ///< JSON file; empty: of the experiment, the replayed file, the default
  std::string input = "-";
  FrameFormat format = FrameFormat::detect;
  std::string reference;  ///< HDF5 file, or "model"; empty: of the replayed file
  int background = 0;     ///< so many first frames are the reference in place of that
  std::string quiet;      ///< HDF5 file of frames in which nothing touches, FILE[@RATE]
  double false_alarms_per_hour = 10;
  std::string forces;  ///< dataset of single touches with known forces
  int repeat = 1;      ///< how often a file is replayed
  std::size_t places = 1;
  bool lossless = false;
  double silence_s = 2;
  double deadline_s = 0;  ///< 0: none
  std::string http;       ///< HOST:PORT; empty: no page
  int http_clients = 4;
  std::string record;  ///< empty: none
  bool images = false;
  int threads = 1;  ///< while the solver is fitted
};

/// Everything that a stream needs before its first frame.
struct LiveSetup {
  std::string solver_name;  ///< label or type
  std::string parameters;   ///< of the solver, JSON
  std::unique_ptr<LiveSolver> solver;
  std::unique_ptr<LiveSource> source;
  bool checked = true;                       ///< whether frames are checked for noise and range
  std::vector<std::filesystem::path> files;  ///< of frames that it reads, not to be written over
};

/// Reads, fits and opens all of it. The solver of an experiment comes from the cache, or is fitted
/// and put there; one of a file has a "checkpoint" or needs no data, as `reconstruct` has it. Loads
/// plugins into this process. Throws InputError.
LiveSetup live_setup(const LiveOptions& options, SolverRegistry& registry);

}  // namespace ertbench
