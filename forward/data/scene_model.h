#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/touch/indenter.h"

namespace ertbench {

class SceneModel;

/// The Cramér-Rao bound of one touch at rest whose indenter is known: the least covariance that any
/// unbiased estimate of (x mm, y mm, force N) can have from one frame of the set's noise, (J^T
/// J)^-1 s^2 with J the derivatives of the voltages and s the noise of a channel.
///
/// The derivatives are central differences of the forward model over 0.1 mm and a hundredth of the
/// force. `model` has the spec's sensor and SheetModel; the spec has noise. The faults of the sheet
/// are left out.
Eigen::Matrix3d touch_bound(const DatasetSpec& spec, const SceneModel& model, const Touch& touch);

/// Noise of one channel on a frame of these clean voltages, V.
double channel_noise(const DatasetSpec& spec, const SceneModel& model,
                     const Eigen::Ref<const Eigen::VectorXd>& frame);

/// What makes the clean voltages of a dataset's scenes: the finite-element model on a grid
/// (ForwardModel), or with "grid": "auto" the border integral equation of the continuous sheet
/// (BorderModel) with as many points as each scene needs.
///
/// All functions are const and thread-safe.
class SceneModel {
 public:
  SceneModel(const Sensor& sensor, const SheetModel& model);
  ~SceneModel();
  SceneModel(SceneModel&&) noexcept;

  /// Voltages of the uniform sheet, [channels] V.
  const Eigen::VectorXd& reference_voltages() const;

  /// Voltages [scenes, channels] V of `scenes`, with the dataset's faults of the sheet and without
  /// noise. `numbers` [scenes]: of whose draws of these faults each has. `spec` has this model's
  /// sensor and SheetModel, but for the model error, which is the spec's.
  ///
  /// `effort` [scenes, 2], filled with "auto" alone: points of each scene's system, and the
  /// estimated 2-norm of its voltages' error in V, which is at most the spec's `model_error` of the
  /// frame's noise except where the model's largest system did not suffice.
  void solve(const DatasetSpec& spec, std::span<const Scene> scenes,
             std::span<const std::uint64_t> numbers, Eigen::Ref<Frames> voltages,
             Eigen::Ref<RowMajorMatrix> effort) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The frames of one sequence of a set, one after the other: what each drive finds on the skin.
class SequenceFrames {
 public:
  /// `spec.scenes` holds a SequenceSet.
  SequenceFrames(const DatasetSpec& spec, std::uint64_t sequence);

  struct Frame {
    /// The skin at the middle of each drive; one for all of them where nothing moves.
    std::vector<Scene> drives;
    Scene truth;        ///< the skin at the middle of the frame
    double time_s = 0;  ///< of that, since the beginning of the sequence
  };

  /// The next frame.
  Frame next();
  /// Leaves out so many.
  void skip(std::uint64_t frames);

 private:
  /// The skin's pressures at a later moment, [patches^2] kPa.
  void move_to(double time_s);

  const DatasetSpec& spec_;
  FrameTiming timing_;
  TouchSequence sequence_;
  double frame_ = 0;
  double now_s_ = 0;
  std::vector<Touch> touches_;
  Eigen::VectorXd relaxed_kPa_;
  FoamMemory foam_;
};

class SceneModel;

/// Voltages [frames, channels] V of frames whose drives find different scenes: of each drive those
/// that its own scene gives. `numbers` [frames]: as SceneModel::solve has them.
///
/// Where nothing moves a frame costs one scene. Where the voltages at the frame's middle lie on the
/// line between those at its ends up to `tolerance` of the noise (2-norm of a frame), the parabola
/// through the three stands for all drives; elsewhere every drive is solved for.
void solve_drives(const DatasetSpec& spec, const SceneModel& model,
                  const std::vector<SequenceFrames::Frame>& frames,
                  const std::vector<std::uint64_t>& numbers, double tolerance,
                  Eigen::Ref<Frames> voltages);

/// Of solve_drives, for datasets.
inline constexpr double drive_tolerance = 0.05;

}  // namespace ertbench
