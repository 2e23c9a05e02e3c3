#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "forward/data/dataset_spec.h"
#include "forward/touch/skin_touch.h"

namespace ertbench {

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
