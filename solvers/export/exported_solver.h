#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/json.h"
#include "solvers/export/c_source.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// Frames at most whose changes calibrate the steps of an int8 program.
inline constexpr std::uint64_t int8_calibration_frames = 200;

/// Makes a solver from an entry of a "solvers" list, as a SolverRegistry does.
using MakeSolver = std::function<std::unique_ptr<Solver>(const JsonObject& entry)>;

/// A fitted solver that was loaded to be exported.
struct SolverToExport {
  Sensor sensor;
  std::unique_ptr<Solver> solver;
  LayerList layers;
  ExportProgram program;
  FrameFront front;             ///< none unless it is needed or asked for
  Eigen::VectorXd frame_check;  ///< its numbers (FrameCheck::packed)
};

/// Loads the fitted solver in `file`, with the front that it needs or, with `front`, the one that
/// every solver has in the program. Throws InputError naming it where it has no layers.
SolverToExport load_to_export(const std::filesystem::path& file, const MakeSolver& make,
                              bool front = false);

/// Prepares the program for int8: changes [frames, channels] V, of frames like those to come.
/// Returns the ranges of its values. A network that is told of dead electrodes sees one in every
/// second frame.
std::vector<double> calibrate(SolverToExport& exported, Frames changes);

/// A fitted solver as C, `{"type": "exported", "of": NAME, "precision": "int8"}`: written and
/// compiled by the system's C compiler when it is fitted or loaded, and called as a library. What
/// is kept of a fit are numbers alone.
class ExportedSolver final : public Solver {
 public:
  static constexpr const char* type = "exported";
  ExportedSolver(JsonObject object, MakeSolver make);
  ~ExportedSolver() override;

  nlohmann::json parameters() const override;
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  /// The code finds the dead electrodes of each frame, if it has a front.
  MaskedChannels masked_channels() const override { return {.detect = has_front_}; }
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  class Library;
  /// Writes, compiles and loads the code. `calibration`: changes of frames; not used but by int8.
  void compile(const Sensor& sensor, const Frames& calibration);

  std::string of_;
  std::filesystem::path fitted_;
  ExportPrecision precision_;
  MakeSolver make_;
  Sensor sensor_;
  Frames calibration_;
  bool has_front_ = false;
  std::unique_ptr<const Library> library_;
};

/// The solver of this room.
std::vector<SolverType> exported_solvers(const MakeSolver& make);

}  // namespace ertbench
