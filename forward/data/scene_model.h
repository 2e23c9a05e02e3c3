#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

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

}  // namespace ertbench
