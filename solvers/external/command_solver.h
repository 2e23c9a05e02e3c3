#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/files.h"
#include "core/json.h"
#include "forward/data/fresh_scenes.h"
#include "forward/sheet/sensor.h"
#include "solvers/external/program.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// A solver with zero images: another process reads the frames by the protocol of CommandSolver and
/// answers at once, so that its time is that of the pipes and the two context switches. Throws
/// std::system_error if no process can be made.
std::unique_ptr<Solver> echo_solver(const Sensor& sensor);

/// A program of any language as a solver. It is started by `fit` and by `load`, in the folder of
/// the experiment, and lives as long as the solver. Its standard input and output are binary, its
/// standard error is its log. It
///
/// 1. reads one line of JSON: `{"protocol": 1 or 2, "sensor": {...}, "channels": 208, "image": [24,
/// 24],
///    "background": 0.06, "reference_voltages": [...], "train": PATH|null, "validation": PATH|null,
///    "parameters": {...}, "work_folder": PATH, "threads": N}`; `work_folder` is kept with the fit:
///    a program that finds its own files there need not fit again; "seed" if the entry has one;
/// 2. fits, then writes one line `{"ready": true, "parameters": {...}}`, or `{"error": "..."}`;
/// 3. until the end of its input: reads a little-endian uint64 n, then n x channels float64
///    (changes, V); writes n x pixels float64 (delta sigma, S/m; row 0 at y = -1) and n bytes of
///    status (FrameStatus).
///
/// By protocol 2 it may write lines `{"scenes": n}` before that of step 2, also ahead of its need.
/// For each it reads the next n FreshScenes of the training set: n x channels float64, then
/// n x pixels float64, as in step 3. It must have read all when it is ready.
///
/// Failures of the program (no answer in time, a crash, garbage) throw FailedTrial. The fitted file
/// holds the line of step 1, with paths relative to that file.
class CommandSolver final : public Solver {
 public:
  static constexpr const char* type = "command";
  /// Throws InputError if the command is empty or names a program that does not exist.
  explicit CommandSolver(JsonObject object);

  /// The command and, once the program is ready, the parameters that it reports.
  nlohmann::json parameters() const override;
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  /// A batch that fits into pipe buffers of a megabyte.
  Eigen::Index block_frames() const override { return 128; }
  std::unique_ptr<Solver> transport() const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  /// Folder for the program's files: that of the fit, or a temporary one of this solver.
  std::filesystem::path work_folder(const FitInput& input);
  void start(const Sensor& sensor);
  /// The next line of the program, which must be an object.
  nlohmann::json answer();
  void send_scenes(const nlohmann::json& count);

  std::vector<std::string> command_;
  nlohmann::json files_;  ///< null without files
  nlohmann::json given_;  ///< "parameters" of the experiment
  int protocol_;
  std::optional<int> seed_;
  double ready_limit_s_;
  double frame_limit_s_;
  double memory_limit_mb_;        ///< 0: the trial's limit
  std::filesystem::path folder_;  ///< of the experiment
  std::string name_;              ///< "python3 my_method.py", for messages

  Sensor sensor_;
  std::optional<TemporaryFolder> passing_folder_;
  nlohmann::json request_;  ///< the line of step 1
  nlohmann::json used_;     ///< the parameters of step 2
  std::unique_ptr<Program> program_;
  std::optional<FreshScenes> fresh_;  ///< once the program has asked for them
  std::unique_ptr<FrameExchange> exchange_;
};

/// The solvers of this room.
std::vector<SolverType> external_solvers();

}  // namespace ertbench
