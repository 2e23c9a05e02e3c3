#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Conductivity of the sheet below a patch relative to the background, at a mean pressure `kPa` >=
/// 0 on the patch. 1 without pressure, strictly monotone (FallingLaw, RisingLaw).
double conductivity_ratio(const ContactLaw& law, double kPa);

class JsonObject;

/// A ball: on a foam of stiffness k = modulus / thickness a force F gives the contact radius a with
/// F = pi k a^4 / 4R and the pressure k (a^2 - r^2) / 2R.
struct Sphere {
  double radius_mm = 15;  ///< assumed

  bool operator==(const Sphere&) const = default;
};

/// A stiff body with a flat face: the same pressure F / area everywhere on it. A disc, an ellipse
/// (a fingertip) or a polygon.
struct FlatFace {
  Eigen::Vector2d semi_axes_mm = {10, 10};   ///< unused for a polygon
  double angle = 0;                          ///< of the first axis against x, rad
  std::vector<Eigen::Vector2d> vertices_mm;  ///< of a polygon, around its centre (0, 0)

  bool operator==(const FlatFace&) const = default;
};

/// A body that presses on the skin, in coordinates around its own centre.
struct Indenter {
  std::variant<FlatFace, Sphere> body;

  bool operator==(const Indenter&) const = default;

  /// For people: "ball of radius 15 mm", "disc of radius 10 mm", "ellipse of 8 x 10 mm".
  std::string text() const;
};

/// Reads `{"type": "sphere", "radius_mm"}`, `{"type": "flat", "radius_mm"}`, `{"type": "flat",
/// "vertices_mm"}` or `{"type": "finger", "semi_axes_mm": [8, 10], "angle"}`; every key but the
/// type and the vertices is optional.
Indenter indenter_from_json(JsonObject object);
nlohmann::json to_json(const Indenter& indenter);

/// An indenter pressed on the skin.
struct Touch {
  Indenter indenter;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< from the sheet's centre
  double force_N = 0;
};

/// The area under pressure, in mm: a disc, an ellipse or a polygon. The force must be > 0.
Contact footprint_mm(const Touch& touch, const Foam& foam);

/// Mean pressure on an axis-parallel box, kPa, once the foam has relaxed. Pressure integrated over
/// boxes that cover the footprint is the force: 1 N is 1000 kPa mm^2.
double mean_pressure_kPa(const Touch& touch, const Foam& foam, const Eigen::AlignedBox2d& box_mm);

/// Mean pressures on the patches of the sensor's skin, [patches^2] kPa, once the foam has relaxed:
/// the sum over the touches. Pressure off the sheet or between patches is lost.
Eigen::VectorXd relaxed_pressure_kPa(const Sensor& sensor, std::span<const Touch> touches);

/// The scene of a skin with pressures [patches^2] kPa on its patches. Its contacts are the
/// `touches` with a force.
Scene skin_scene(const Sensor& sensor, std::span<const Touch> touches,
                 const Eigen::VectorXd& pressure_kPa);

/// The scene of a skin long after the touches came to rest.
Scene still_scene(const Sensor& sensor, std::span<const Touch> touches);

/// The foam's memory of each patch: the pressure p follows what it would be after relaxing, p_inf,
/// by p = s p_inf + (1 - s) m with tau dm/dt = p_inf - m, s Foam::prompt_share, tau
/// Foam::relaxation_s. The same holds on release, so that an impression of the finger remains.
class FoamMemory {
 public:
  /// Starts long at rest under `relaxed_kPa` [patches^2].
  FoamMemory(const Foam& foam, Eigen::VectorXd relaxed_kPa);

  /// Advances the time while the relaxed pressure changes linearly to `relaxed_kPa`.
  void advance(double seconds, const Eigen::VectorXd& relaxed_kPa);

  Eigen::VectorXd pressure_kPa() const;

 private:
  Foam foam_;
  Eigen::VectorXd relaxed_;
  Eigen::VectorXd remembered_;
};

}  // namespace ertbench
