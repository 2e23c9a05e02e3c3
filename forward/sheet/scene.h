#pragma once

#include <Eigen/Geometry>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "forward/sheet/pixel_grid.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// Range of a contact's conductivity over the background's. A lower ratio insulates no better, and
/// would make the stiffness of its elements vanish.
inline constexpr std::array<double, 2> conductivity_ratios = {1e-6, 1000};
/// Range of a contact's radius, half axis or half side, domain units. It keeps areas, boxes and
/// their inverses finite.
inline constexpr std::array<double, 2> contact_lengths = {1e-6, 100};

class JsonObject;

enum class Shape { disc = 0, ellipse = 1, rectangle = 2, polygon = 3 };

/// One pressed region of the sheet. Lengths in domain units (see Sheet).
struct Contact {
  Shape shape = Shape::disc;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< unused for a polygon
  /// Semi-axes of an ellipse, half sides of a rectangle, (radius, radius) for a disc;
  /// unused for a polygon.
  Eigen::Vector2d half_size = Eigen::Vector2d::Zero();
  double angle = 0;                       ///< of the first axis against x, counter-clockwise, rad
  std::vector<Eigen::Vector2d> vertices;  ///< of a polygon: absolute, in order, not self-crossing
  double conductivity_ratio = 1;          ///< sigma / background inside the contact, > 0
  /// Force of a touch of the skin, N; 0 if unknown. The shape is then its footprint, the patches of
  /// the scene have the conductivities, and the ratio is that of the patch that changed most.
  double force_N = 0;

  /// Smallest axis-parallel box around the contact.
  Eigen::AlignedBox2d bounds() const;
  bool contains(const Eigen::Vector2d& point) const;
  /// Centre of area; a polygon's is computed from its vertices.
  Eigen::Vector2d centroid() const;
};

/// Contacts on the sheet. Where they overlap, the lowest conductivity ratio counts, so that their
/// order does not matter; parts outside the sheet are cut off.
///
/// On a skin (Skin) the patches have the conductivities, and the contacts are the footprints of the
/// touches.
struct Scene {
  std::vector<Contact> contacts;
  std::optional<PatchField> patches = {};
};

/// `{"contacts": [{"shape": "ellipse", "centre": [x, y], "semi_axes": [a, b], "angle": radians,
/// "conductivity_ratio": 0.6}]}`; a `disc` has `radius`, a `rectangle` `half_sides`, a `polygon`
/// `vertices` in place of a centre. Lengths and places may stand in millimetres: `centre_mm`,
/// `radius_mm`, ... (SheetLengths).
Scene scene_from_json(JsonObject object, const Sheet& sheet);
nlohmann::json to_json(const Scene& scene);

const char* name_of(Shape shape);
Shape shape_named(const std::string& name);  ///< one of the four names

/// The foam between indenter and patches: a bed of independent springs (Winkler), each a standard
/// linear solid. A share `prompt_share` of the pressure follows the indentation at once, the rest
/// with the time constant `relaxation_s`.
struct Foam {
  double thickness_mm = 3;    ///< assumed; the paper gives none
  double modulus_MPa = 0.5;   ///< assumed: soft neoprene
  double prompt_share = 0.8;  ///< assumed
  double relaxation_s = 0.3;  ///< assumed; 0 for a foam without relaxation

  bool operator==(const Foam&) const = default;
};

/// Conductivity falls with pressure, as in the paper's simulations (0.1 to 0.9 of the background):
/// f = 1 - depth p / (p + half_pressure). Saturating and monotone; both numbers are assumed.
struct FallingLaw {
  double depth = 0.9;
  double half_pressure_kPa = 20;

  bool operator==(const FallingLaw&) const = default;
};

/// Conductivity rises with pressure: a patch shunts the film below it through a contact whose
/// conductance is proportional to the load (Greenwood & Williamson 1966). With the transfer length
/// L_T = sqrt(contact resistivity / sheet resistance) and a patch of width w the strip below it has
/// f = x / tanh x with x = w / 2 L_T, and x^2 is proportional to p. The reference point is assumed:
/// by default ratio 10 at 10 N on a disc of radius 10 mm.
struct RisingLaw {
  double reference_pressure_kPa = 31.830988618379067;
  double reference_ratio = 10;

  bool operator==(const RisingLaw&) const = default;
};

using ContactLaw = std::variant<FallingLaw, RisingLaw>;

const char* name_of(const ContactLaw& law);  ///< "falling", "rising"

/// The layers on the sheet: foam with `patches` x `patches` separate square conductive patches at
/// equal distances. Pressure acts through the patches, so that a touch changes one conductivity for
/// each patch and nothing between them.
struct Skin {
  int patches = 24;       ///< along one side
  double patch_mm = 7.5;  ///< side of a patch, mm
  Foam foam;
  ContactLaw law;

  bool operator==(const Skin&) const = default;
};

/// Reads an object with the members' names as keys, every key but the "type" of "law" optional.
/// `side_mm` of the sheet; the patches must fit on it.
Skin skin_from_json(JsonObject object, double side_mm);
nlohmann::json to_json(const Skin& skin);
nlohmann::ordered_json skin_schema();

}  // namespace ertbench
