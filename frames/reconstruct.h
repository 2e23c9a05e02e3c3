#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "frames/own_frames.h"

namespace ertbench {

/// Throws InputError unless `output` may be written by `reconstruct`: nothing stands there, or
/// images that it made, and it is none of the `inputs` (require_output).
void require_image_output(const std::filesystem::path& output,
                          const std::vector<std::filesystem::path>& inputs);

/// What a reconstruction reads: the solver's specification, the checkpoint that it names, frames.
std::vector<std::filesystem::path> reconstruction_inputs(const std::filesystem::path& spec_file,
                                                         const std::filesystem::path& frames);

class SolverRegistry;

/// What is to be reconstructed, and how.
struct ReconstructOptions {
  /// One entry of an experiment's "solvers" list; `"checkpoint"` in it names the file of a fitted
  /// solver, relative to it. With a calibration a solver without one is fitted on scenes with the
  /// noise that was measured (write_calibrated_set), so that it may choose parameters by itself and
  /// judge frames.
  std::filesystem::path solver;
  OwnFramesOptions frames;
  std::filesystem::path output;
  bool fix = false;    ///< read the frames as check_reference says, where that mends them
  bool force = false;  ///< image them whatever it says
};

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
  bool checked = true;    ///< for noise and range, too: see FrameCheck::has_limits
  std::string reference;  ///< what the check of the reference voltages says, in lines
};

/// Reconstructs a file of frames (OwnFrames). `output`: `/conductivity_change` [N, rows, columns]
/// S/m, `/status` [N] (0 ok, 1 not converged, 2 undefined: its image is NaN, 3 suspect: an image,
/// but not a frame to trust), `/reason` [N] (the sum of FrameReason's), `/x_mm` [columns] and
/// `/y_mm` [rows] of the pixels' centres, `/reference_voltages` [channels] V,
/// `/channel_map` [channels, 3] (ChannelMap::table), and as attributes of the root, in JSON,
/// "sensor", "solver" and "source" (OwnFrames::description).
/// Written aside and renamed.
///
/// Before the first image the reference voltages are held against the model of the sensor
/// (check_reference): where they are not what it expects, nothing is imaged unless the options say
/// otherwise.
///
/// Frames are streamed. A file so damaged that the HDF5 library itself crashes or hangs on it is
/// found out in a child process first, and the solver, which may come from a plugin, runs in a
/// child too. Throws InputError for whatever cannot be used, for an output that is one of the
/// inputs or another file than such images, and where the solver ends its process.
ReconstructSummary reconstruct_file(const ReconstructOptions& options, SolverRegistry& registry);

/// Reads a file of frames from its beginning to its end, and throws InputError where it cannot be
/// used. The HDF5 library itself crashes or hangs on some damaged files: reconstruct_file calls
/// this in a child process first, the fuzzing target (tests/fuzz) in its own.
void read_frames(const OwnFramesOptions& options);
void read_frames(const std::filesystem::path& input);

/// Runs what reads the file `path` in a child: the HDF5 library does not survive every damaged
/// file, and InputError is thrown where it does not. What the child finds wrong in an orderly way,
/// the reading that counts finds again.
void survive_reading(const std::filesystem::path& path, const std::function<void()>& read);

/// What there is to say of a calibration.
struct CalibrationOutcome {
  Calibration calibration;
  ReferenceVerdict verdict;
};

/// Calibrates on frames of a file (all of them, or its rows `options.background`), and writes the
/// calibration as JSON to `output`, with "source": OwnFrames::description. Throws InputError for
/// fewer than ten frames, for more than a million, for reference voltages that are beyond help and
/// such as would have to be mended first, unless `force`; and where `output` is something else than
/// a calibration.
CalibrationOutcome calibrate_file(const OwnFramesOptions& options,
                                  const std::filesystem::path& output, bool fix, bool force);

}  // namespace ertbench
