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

/// Cramér-Rao bound of one touch at rest with a known indenter: the least covariance of an unbiased
/// estimate of (x mm, y mm, force N) from one frame with the set's noise, (J^T J)^-1 s^2 with the
/// derivatives J of the voltages and the noise s of a channel.
///
/// Derivatives are central differences of the forward model over 0.1 mm and a hundredth of the
/// force. `model` must have the spec's sensor and SheetModel, and the spec noise. Faults of the
/// sheet are ignored.
Eigen::Matrix3d touch_bound(const DatasetSpec& spec, const SceneModel& model, const Touch& touch);

/// Model of a dataset's clean voltages: finite elements on a grid (ForwardModel) or, with "grid":
/// "auto", the border integral equation of the continuous sheet (BorderModel) with as many points
/// as each scene needs.
///
/// All functions are const and thread-safe.
class SceneModel {
 public:
  SceneModel(const Sensor& sensor, const SheetModel& model);
  ~SceneModel();
  SceneModel(SceneModel&&) noexcept;

  /// Voltages of the uniform sheet, [channels] V.
  const Eigen::VectorXd& reference_voltages() const;

  /// Computes `voltages` [scenes, channels] V with the dataset's faults of the sheet and without
  /// noise. `numbers` [scenes] are the scene numbers for which these faults are drawn. `spec` must
  /// have this model's sensor and SheetModel; the allowed model error is the spec's.
  ///
  /// `effort` [scenes, 2] is filled with "auto" only: points of each scene's system, and the
  /// estimated 2-norm of its voltages' error in V. That is at most `model_error` of the frame's
  /// noise unless the largest system did not suffice.
  void solve(const DatasetSpec& spec, std::span<const Scene> scenes,
             std::span<const std::uint64_t> numbers, Eigen::Ref<Frames> voltages,
             Eigen::Ref<RowMajorMatrix> effort) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Generates the frames of one sequence of a set, with the skin's state at each drive.
class SequenceFrames {
 public:
  /// `spec.scenes` holds a SequenceSet.
  SequenceFrames(const DatasetSpec& spec, std::uint64_t sequence);

  struct Frame {
    /// The skin at the middle of each drive; a single scene if nothing moves.
    std::vector<Scene> drives;
    Scene truth;        ///< the skin at the middle of the frame
    double time_s = 0;  ///< middle of the frame, since the beginning of the sequence
  };

  /// The next frame.
  Frame next();
  /// Advances by so many frames.
  void skip(std::uint64_t frames);

 private:
  /// Advances the skin's pressures [patches^2] kPa to a later time.
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

/// Computes `voltages` [frames, channels] V of frames in which each drive has its own scene.
/// `numbers` [frames] as for SceneModel::solve.
///
/// A frame without motion costs one scene. If the voltages at the frame's middle deviate from the
/// line between those at its ends by at most `tolerance` of the noise (2-norm of a frame), the
/// parabola through the three is used for all drives; otherwise every drive is solved.
void solve_drives(const DatasetSpec& spec, const SceneModel& model,
                  const std::vector<SequenceFrames::Frame>& frames,
                  const std::vector<std::uint64_t>& numbers, double tolerance,
                  Eigen::Ref<Frames> voltages);

/// Tolerance of solve_drives for datasets.
inline constexpr double drive_tolerance = 0.05;

}  // namespace ertbench
