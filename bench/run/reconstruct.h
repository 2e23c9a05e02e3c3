#pragma once

#include <cstdint>
#include <filesystem>

namespace ertbench {

class SolverRegistry;

struct ReconstructSummary {
  std::uint64_t frames = 0;
  std::uint64_t not_converged = 0;
  std::uint64_t undefined = 0;
  std::uint64_t suspect = 0;
  /// Frames with each FrameReason; a suspect frame has one or more, one with masked electrodes too.
  std::uint64_t dead_electrode = 0;
  std::uint64_t noise = 0;
  std::uint64_t out_of_range = 0;
  std::uint64_t unexplained = 0;
  bool checked = true;  ///< for noise and range, too: see FrameCheck::has_limits
};

/// Reconstructs a file of frames. `spec_file`: one entry of an experiment's "solvers" list;
/// `"checkpoint"` in it names the file of a fitted solver, relative to the spec. `input`:
/// `/voltages` [N, channels] V and `/reference_voltages` [channels] V; its root attribute "sensor"
/// (JSON) describes the sensor, d2s where there is none. `output`: `/conductivity_change`
/// [N, grid, grid] S/m, `/status` [N] (0 ok, 1 not converged, 2 undefined: its image is NaN, 3
/// suspect: an image, but not a frame to trust) and `/reason` [N] (the sum of FrameReason's),
/// written aside and renamed.
///
/// Frames are streamed. A file so damaged that the HDF5 library itself crashes or hangs on it is
/// found out in a child process first, and the solver, which may come from a plugin, runs in a
/// child too. Throws InputError for whatever cannot be used, for an output that is one of the
/// inputs or another file than such images, and where the solver ends its process.
ReconstructSummary reconstruct_file(const std::filesystem::path& spec_file,
                                    const std::filesystem::path& input,
                                    const std::filesystem::path& output, SolverRegistry& registry);

/// Reads a file of frames from its beginning to its end, and throws InputError where it cannot be
/// used. The HDF5 library itself crashes or hangs on some damaged files: reconstruct_file calls
/// this in a child process first, the fuzzing target (tests/fuzz) in its own.
void read_frames(const std::filesystem::path& input);

}  // namespace ertbench
