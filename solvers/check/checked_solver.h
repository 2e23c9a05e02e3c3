#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "forward/sheet/sensor.h"
#include "solvers/front/front.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// Type and sensor of the fitted solver in a file.
struct SolverOwner {
  std::string type;
  Sensor sensor;
};

/// Adds the numbers of the frame check to the file that a solver has just saved, and its owner
/// (write_owner) if the solver has not written it.
///
/// - An HDF5 file gets the dataset `/frame_check` beside the solver's own datasets.
/// - Any other file, or one with a `/frame_check` of its own, becomes a container: an HDF5 file
/// with
///   the attribute `contains_solver_file`, the solver's file byte by byte in `/solver_file`, and
///   `/frame_check`. If the solver saved nothing there is no `/solver_file`.
void add_frame_check(const std::filesystem::path& file, const SolverOwner& owner,
                     const Eigen::VectorXd& numbers);

/// A file of a fitted solver, opened for loading.
class CheckedFile {
 public:
  /// Throws InputError if there is no file, or it has another owner.
  CheckedFile(const std::filesystem::path& file, const SolverOwner& owner);

  /// The file to pass to Solver::load: `file` itself, or the unpacked contents of a container.
  const std::filesystem::path& of_solver() const { return of_solver_; }
  /// Numbers of the frame check; no value in files from before it existed.
  const std::optional<Eigen::VectorXd>& frame_check() const { return frame_check_; }

 private:
  std::optional<TemporaryFolder> unpacked_;
  std::filesystem::path of_solver_;
  std::optional<Eigen::VectorXd> frame_check_;
};

/// Wrapper that the registry puts around every solver, built-in or from a plugin, for the duties
/// common to all.
///
/// - Refuses calls that break the contract: an unfitted solver, shapes that do not match.
/// - Passes frames in blocks of the size that the solver wants.
/// - Reports a frame as undefined if it or its image is not finite; channels that the solver masks
///   in every frame may read anything.
/// - Flags frames that should not be trusted by a FrameCheck, which is fitted with the solver and
///   kept in its file. A solver that asks for it gets the dead electrodes before it reconstructs;
///   any other gets frames whose dead channels are replaced by their mean given the live ones.
///   Those of a loose contact are replaced for all.
/// - Refuses files of another type of solver, and files and datasets of another sensor.
/// - Loads the file that its parameter "checkpoint" names in place of a fit.
///
/// Allocates nothing and adds 1 us to a frame, except when contacts are detected in a frame with
/// dead electrodes.
class CheckedSolver final : public Solver {
 public:
  /// Reads its own keys from the object and leaves the rest to `info.make`.
  static std::unique_ptr<Solver> make(const std::string& type, const SolverInfo& info,
                                      JsonObject parameters);
  /// Parameters of the wrapper: "checkpoint", "inference_check", ...
  static std::vector<ParameterInfo> own_parameters();

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override;
  bool needs_training() const override { return stored_.empty() && inner_->needs_training(); }
  /// With a checkpoint only the sensor of the input is used.
  void fit(const FitInput& input) override;
  /// The solver's report, and whether the frame check could be fitted (FrameCheck::has_limits).
  FitReport fit_report() const override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  Eigen::Index block_frames() const override { return inner_->block_frames(); }
  MaskedChannels masked_channels() const override { return inner_->masked_channels(); }
  std::unique_ptr<Solver> transport() const override { return inner_->transport(); }
  /// Frames of all channels from those of the channels `kept`: the others are imputed
  /// (FrameCheck::impute). Throws InputError if the frame check has no limits.
  Frames completed(FramesView changes, const std::vector<int>& kept) const {
    if (!check_.has_limits()) {
      throw InputError(type_ +
                       ": was fitted on too few frames to estimate channels that are left out; fit "
                       "it on 100 or more, or on the sensor without these channels");
    }
    Frames out = Frames::Zero(changes.rows(), sensor_.channels());
    out(Eigen::all, kept) = changes;
    for (Eigen::Index f = 0; f < out.rows(); ++f) check_.impute(out.row(f).data(), kept);
    return out;
  }
  /// The solver's own, wrapped so that it gets the dead electrodes of each frame if it asks for
  /// them and has streams.
  const ContactFinder* contact_finder() const override;
  /// The wrapped solver as the interface `Optional`; null if it has none.
  template <typename Optional>
  const Optional* inner_as() const {
    return dynamic_cast<const Optional*>(inner_.get());
  }
  /// Never null.
  std::unique_ptr<FrameStream> open_stream() const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  CheckedSolver(std::string type, JsonObject& own);

  class Stream;
  class MaskingFinder;

  /// Reconstructs by `stream`, or by the solver if that is null.
  void reconstruct_with(FrameStream* stream, FramesView changes, ImagesView images,
                        std::span<FrameReport> reports) const;
  void reconstruct_block(FrameStream* stream, FramesView changes, ImagesView images,
                         std::span<FrameReport> reports) const;
  bool is_finite(const FramesView& changes, const ImagesView& images, Eigen::Index frame) const;
  /// A copy of the frames with zeros in the masked channels; no value if all of those are finite.
  std::optional<Frames> without_masked(FramesView changes) const;
  /// A copy of the frames without nuisances and with the channels of dead electrodes imputed where
  /// those are to be and can be; no value if there is nothing to do.
  std::optional<Frames> prepared(FramesView changes,
                                 const std::vector<FrameCheck::Verdict>& verdicts) const;
  FrameCheck fitted_check(const FitInput& input) const;
  void become_ready(const Sensor& sensor, FrameCheck check);
  /// Throws InputError if a parameter of the entry is not the one that the stored solver has.
  void require_stored_parameters() const;

  std::string type_;
  std::unique_ptr<Solver> inner_;
  JsonValue entry_;               ///< as written
  std::filesystem::path stored_;  ///< the file of its "checkpoint"; empty: it is fitted
  bool check_frames_;             ///< "inference_check"
  bool imputes_;                  ///< "inference_imputation"
  bool sets_limits_;              ///< "inference_limits"
  Nuisances nuisances_;           ///< "inference_nuisances", taken out of frames
  bool ready_ = false;            ///< fitted or loaded
  Sensor sensor_;
  MaskedChannels masked_;
  bool told_ = false;                    ///< ToldSolver::is_told
  std::vector<Eigen::Index> off_sheet_;  ///< pixels without any sheet, zero in every image
  /// Channels that the solver uses, if it masks some in every frame; else empty.
  std::vector<Eigen::Index> taken_;
  std::unique_ptr<const ContactFinder> finder_;  ///< null: the solver's own is used
  FrameCheck check_;
  std::optional<Front> front_;  ///< that takes out nuisances
};

}  // namespace ertbench
