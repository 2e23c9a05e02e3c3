#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/files.h"
#include "forward/sheet/sensor.h"
#include "solvers/check/frame_check.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// Whose fitted solver a file holds.
struct SolverOwner {
  std::string type;
  Sensor sensor;
};

/// Adds the numbers of the check of frames to what a solver has just saved in `file`, and whose it
/// is (write_owner) where the solver has not said so.
///
/// - Into an HDF5 file as the dataset `/frame_check`, beside the solver's own.
/// - Any other file, or one whose `/frame_check` is its own, becomes a container: an HDF5 file with
///   the attribute `contains_solver_file`, the solver's file byte for byte in `/solver_file`, and
///   `/frame_check`. Where the solver saved nothing there is no `/solver_file`.
void add_frame_check(const std::filesystem::path& file, const SolverOwner& owner,
                     const Eigen::VectorXd& numbers);

/// A file of a fitted solver, opened to be loaded.
class CheckedFile {
 public:
  /// Throws InputError where there is no file, or it says that it is another's.
  CheckedFile(const std::filesystem::path& file, const SolverOwner& owner);

  /// What the solver itself saved, for Solver::load: the file, or a copy of what it contains.
  const std::filesystem::path& of_solver() const { return of_solver_; }
  /// None in a file from before there were any.
  const std::optional<Eigen::VectorXd>& frame_check() const { return frame_check_; }

 private:
  std::optional<TemporaryFolder> unpacked_;
  std::filesystem::path of_solver_;
  std::optional<Eigen::VectorXd> frame_check_;
};

/// What the registry puts around every solver, built-in or from a plugin: the duties that are the
/// same for all.
///
/// - Calls that break the contract are refused: an unfitted solver, shapes that do not fit.
/// - Frames are given in blocks of the size that the solver wants.
/// - A frame that is not finite, or whose image is not, is undefined; what channels read that the
///   solver leaves out in every frame does not matter.
/// - FrameCheck, fitted with the solver and kept in its file, says which frames are not to be
///   trusted, and, before they are imaged, to a solver that asks for it, which electrodes are dead.
/// - A file of another type of solvers or another sensor is refused, and so are datasets of another
///   sensor.
///
/// Adds nothing to the heap, and to the time of a frame that of the judgement (1 us), but where
/// contacts are asked for of a frame with dead electrodes.
class CheckedSolver final : public Solver {
 public:
  /// Takes its own keys from the object and leaves the rest to `info.make`.
  static std::unique_ptr<Solver> make(const std::string& type, const SolverInfo& info,
                                      JsonObject parameters);
  /// Those of its own: "inference_check".
  static std::vector<ParameterInfo> own_parameters();

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override { inner_->check(sensor); }
  bool needs_training() const override { return inner_->needs_training(); }
  void fit(const FitInput& input) override;
  /// The solver's own, and what is left of the check of frames (FrameCheck::has_limits).
  FitReport fit_report() const override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  Eigen::Index block_frames() const override { return inner_->block_frames(); }
  MaskedChannels masked_channels() const override { return inner_->masked_channels(); }
  std::unique_ptr<Solver> transport() const override { return inner_->transport(); }
  /// The solver's own; one that tells it the dead electrodes of each frame, where it asks for them
  /// and has streams.
  const ContactFinder* contact_finder() const override;
  /// Never null.
  std::unique_ptr<FrameStream> open_stream() const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  CheckedSolver(std::string type, std::unique_ptr<Solver> inner, bool check_frames);

  class Stream;
  class MaskingFinder;

  /// By the solver, or by a stream of it where that is not null.
  void reconstruct_with(FrameStream* stream, FramesView changes, ImagesView images,
                        std::span<FrameReport> reports) const;
  void reconstruct_block(FrameStream* stream, FramesView changes, ImagesView images,
                         std::span<FrameReport> reports) const;
  bool is_finite(const FramesView& changes, const ImagesView& images, Eigen::Index frame) const;
  /// The frames with zeros for what the solver leaves out, where any of that is not finite; else
  /// nothing.
  std::optional<Frames> without_masked(FramesView changes) const;
  void become_ready(const Sensor& sensor, FrameCheck check);

  std::string type_;
  std::unique_ptr<Solver> inner_;
  bool check_frames_;   ///< "inference_check"
  bool ready_ = false;  ///< fitted or loaded
  Sensor sensor_;
  MaskedChannels masked_;
  std::vector<Eigen::Index> off_sheet_;  ///< pixels, which no image changes
  /// Channels that the solver takes, where it leaves some out in every frame; else empty.
  std::vector<Eigen::Index> taken_;
  std::unique_ptr<const ContactFinder> finder_;  ///< null: the solver's own
  FrameCheck check_;
};

}  // namespace ertbench
