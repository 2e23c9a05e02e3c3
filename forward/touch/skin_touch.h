#pragma once

#include <Eigen/Core>
#include <span>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "forward/touch/indenter.h"

namespace ertbench {

/// Mean pressures on the patches of the sensor's skin, [patches^2] kPa, once the foam has relaxed:
/// the sum over the touches. What falls off the sheet or between patches presses nothing.
Eigen::VectorXd relaxed_pressure_kPa(const Sensor& sensor, std::span<const Touch> touches);

/// The skin with these pressures [patches^2] kPa on its patches. `touches` are its contacts, those
/// without a force left out.
Scene skin_scene(const Sensor& sensor, std::span<const Touch> touches,
                 const Eigen::VectorXd& pressure_kPa);

/// The skin long after the touches came to rest.
Scene still_scene(const Sensor& sensor, std::span<const Touch> touches);

/// The foam's memory of each patch: the pressure p follows what it would be after relaxing, p_inf,
/// by p = s p_inf + (1 - s) m with tau dm/dt = p_inf - m, s Foam::prompt_share, tau
/// Foam::relaxation_s; the same on release, so that a ghost stays where a finger was.
class FoamMemory {
 public:
  /// Long at rest under `relaxed_kPa` [patches^2].
  FoamMemory(const Foam& foam, Eigen::VectorXd relaxed_kPa);

  /// Some time later, while the relaxed pressure went evenly to `relaxed_kPa`.
  void advance(double seconds, const Eigen::VectorXd& relaxed_kPa);

  Eigen::VectorXd pressure_kPa() const;

 private:
  Foam foam_;
  Eigen::VectorXd relaxed_;
  Eigen::VectorXd remembered_;
};

}  // namespace ertbench
