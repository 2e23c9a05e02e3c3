#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// What computes the clean voltages of the many scenes that a posterior is sampled with: a forward
/// model as it is, or a faster one for the scenes that it knows.
///
/// All functions are const and thread-safe.
class SceneVoltages {
 public:
  virtual ~SceneVoltages() = default;

  virtual std::string name() const = 0;  ///< as results have it: "border, resolution 1"
  /// Voltages of the uniform sheet, [channels] V.
  virtual const Eigen::VectorXd& reference() const = 0;
  /// `voltages` [scenes, channels] V.
  virtual void solve(std::span<const Scene> scenes, Eigen::Ref<Frames> voltages) const = 0;
  /// Whether the voltages are smooth in a contact's place and size, as those of pixels that a
  /// contact has or has not are not.
  virtual bool is_smooth() const = 0;
};

/// Points a contact of the border model: at 1 its error is a hundredth of the noise of 50 dB.
inline constexpr double usual_resolution = 1;

/// BorderModel::solve_at.
std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor,
                                               double resolution = usual_resolution);
/// ForwardModel on a grid of `side` pixels that are filled by `rule`.
std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule);

/// The largest grid that is solved as it is; of finer ones the border model is the limit.
inline constexpr int largest_own_grid = 48;

/// The model that made the set's own voltages where it is a grid coarse enough to be solved
/// thousands of times; for finer grids and "auto" the border model, to which they converge.
std::unique_ptr<SceneVoltages> voltages_for(const DatasetSpec& spec);

}  // namespace ertbench
