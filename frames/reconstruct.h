#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "frames/own_frames.h"
#include "solvers/solver.h"

namespace ertbench {

/// Throws InputError unless `reconstruct` may write `output`: the file is missing or holds images
/// of an earlier call, and is none of the `inputs` (require_output).
void require_image_output(const std::filesystem::path& output,
                          const std::vector<std::filesystem::path>& inputs);

/// Input files of a reconstruction: the solver's entry, its checkpoint, the frames.
std::vector<std::filesystem::path> reconstruction_inputs(const std::string& solver,
                                                         const std::filesystem::path& frames);

class SolverRegistry;

/// Most contacts of a frame that are written, and numbers of each: x and y of the centre, mm from
/// the middle of the sheet; radius of the disc of its area, mm; largest change of the conductivity,
/// S/m; standard deviations of x and y, mm, 0 if the solver gives none.
inline constexpr std::array<Eigen::Index, 2> written_contacts = {8, 6};
/// The contacts of frames [frames, channels] in V as such rows, [frames, 8 * 6], the strongest
/// first, NaN where there is none. Behind each contact stand its twins (twin_symmetries).
RowMajorMatrix contacts_of(const ContactFinder& finder, const Sensor& sensor,
                           const std::vector<Eigen::Matrix2d>& twins, const Frames& changes);

struct ReconstructOptions {
  /// A file with one entry of an experiment's "solvers" list, or the name of a stored solver
  /// (read_named_solver). Without a checkpoint but with a calibration the solver is fitted on
  /// scenes with the measured noise (write_calibrated_set), so that it can choose "auto" parameters
  /// and check frames.
  std::string solver;
  std::filesystem::path plugin;  ///< library of the user's own solvers, for messages; may be empty
  OwnFramesOptions frames;
  std::filesystem::path output;
  bool fix = false;    ///< mend the frames as check_reference proposes
  bool force = false;  ///< image the frames whatever it finds
};

struct ReconstructSummary {
  std::uint64_t frames = 0;
  std::uint64_t not_converged = 0;
  std::uint64_t undefined = 0;
  std::uint64_t suspect = 0;
  /// Frames with each bit of their reasons (FrameReason, FrameFault); flagged frames and those with
  /// masked electrodes have one or more.
  std::array<std::uint64_t, 8> with_reason{};
  std::vector<std::string> faults;  ///< first frames with a FrameFault: "frame 3: its level ..."
  bool checked = true;              ///< noise and range were checked, see FrameCheck::has_limits
  std::string reference;            ///< text of the check of the reference voltages
};

/// Reconstructs a file of frames (OwnFrames). `output`: `/conductivity_change` [N, rows, columns]
/// S/m, `/status` [N] (0 ok, 1 not converged, 2 undefined: its image is NaN, 3 suspect: an image,
/// but not a frame to trust), `/reason` [N] (the sum of FrameReason's), `/x_mm` [columns] and
/// `/y_mm` [rows] of the pixels' centres, `/reference_voltages` [channels] V,
/// `/channel_map` [channels, 3] (ChannelMap::table), and as attributes of the root, in JSON,
/// "sensor", "solver" and "source" (OwnFrames::description). The file is replaced by atomic rename.
///
/// First the reference voltages are compared with the model of the sensor (check_reference); if
/// they do not fit, nothing is imaged unless the options say otherwise.
///
/// Frames are streamed. A child process reads the file first, because the HDF5 library crashes or
/// hangs on some damaged files; the solver, which may come from a plugin, runs in a child too.
/// Throws InputError for unusable input, for an output that is one of the inputs or not such a file
/// of images, and if the solver ends its process.
ReconstructSummary reconstruct_file(const ReconstructOptions& options, SolverRegistry& registry);

/// Reads a whole file of frames and throws InputError if it cannot be used. On some damaged files
/// the HDF5 library crashes or hangs; call it in a child process (survive_reading).
void read_frames(const OwnFramesOptions& options);
void read_frames(const std::filesystem::path& input);

/// Runs `read`, which reads the file `path`, in a child process and throws InputError if that
/// crashes or hangs. Exceptions of `read` are ignored: the caller reads again and meets them.
void survive_reading(const std::filesystem::path& path, const std::function<void()>& read);

struct CalibrationOutcome {
  Calibration calibration;
  ReferenceVerdict verdict;
};

/// Calibrates on the frames of a file, or on its rows `options.background`, and writes the
/// calibration as JSON to `output`, with "source": OwnFrames::description. Throws InputError for
/// fewer than ten or more than a million frames, if `output` exists and is no calibration, and,
/// unless `force`, for reference voltages that do not fit the sensor and are not mended by `fix`
/// and for frames that are no quiet ones (check_quiet), which `force` leaves out.
CalibrationOutcome calibrate_file(const OwnFramesOptions& options,
                                  const std::filesystem::path& output, bool fix, bool force);

}  // namespace ertbench
