#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// A frame that voltages are computed for.
struct VoltageTarget {
  const Eigen::VectorXd& frame;
  double noise;  ///< 2-norm, V
  std::vector<double>
      farthest;  ///< [scenes] V from the frame: beyond, any accuracy will do; or none
};

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
  /// `voltages` [scenes, channels] V. `target`: what they are to be held against, and need be no
  /// more accurate than; null where the first glance is enough.
  virtual void solve(std::span<const Scene> scenes, const VoltageTarget* target,
                     Eigen::Ref<Frames> voltages) const = 0;
  /// Whether the voltages are smooth in a contact's place and size, as those of pixels that a
  /// contact has or has not are not.
  virtual bool is_smooth() const = 0;
};

/// BorderModel. One disc or ellipse is solved at a resolution whose error is under .02 of the noise
/// of 50 dB everywhere. Other scenes, first at resolution 1, are refined until the error that
/// reciprocity shows is at most `border_tolerance` of the noise, or of the distance to the frame
/// where that is larger: a scene that is far off need not be known well to be refused.
std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor);
inline constexpr double border_tolerance = 0.25;
/// ForwardModel on a grid of `side` pixels that are filled by `rule`.
std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule);

/// The largest grid that is solved as it is; of finer ones the border model is the limit.
inline constexpr int largest_own_grid = 48;

/// Whether voltages_for() is another model than the set's own by more than both are accurate to.
bool has_other_model(const DatasetSpec& spec);
/// As results have it: with what is done about the difference, where there is one.
std::string model_name(const DatasetSpec& spec, const SceneVoltages& voltages);

/// The model that made the set's own voltages where it is a grid coarse enough to be solved
/// thousands of times; for finer grids and "auto" the border model, to which they converge.
std::unique_ptr<SceneVoltages> voltages_for(const DatasetSpec& spec);

}  // namespace ertbench
