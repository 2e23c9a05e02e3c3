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

/// Of a contact's conductivity over the background's. Less is an insulator as good as any, and
/// would leave nothing of the stiffness of its elements.
inline constexpr std::array<double, 2> conductivity_ratios = {1e-6, 1000};
/// Of a contact's radius, half axis or half side, domain units: no contact needs more or less, and
/// areas, boxes and their inverses are finite.
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
  /// Of a touch of the skin, N: the shape is its footprint and the conductivity that of the scene's
  /// patches, of which the ratio is the one that changed most. 0 where nothing is known of a force.
  double force_N = 0;

  /// Corners of the smallest axis-parallel box around the contact.
  Eigen::AlignedBox2d bounds() const;
  bool contains(const Eigen::Vector2d& point) const;
  /// Centre of area; a polygon's is computed from its vertices.
  Eigen::Vector2d centroid() const;
};

/// What presses on the sheet. Where contacts overlap, the lowest conductivity ratio counts, so that
/// the order of the contacts means nothing; what lies outside the sheet is cut off.
///
/// On a skin (Skin) the patches have the conductivities, and the contacts say what was pressed
/// where.
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

class JsonObject;

/// The foam between what presses and the patches: a bed of independent springs (Winkler), each a
/// standard linear solid. Pressure follows indentation at once by `prompt_share`, and with the time
/// constant `relaxation_s` for the rest.
struct Foam {
  double thickness_mm = 3;    ///< assumed; the paper gives none
  double modulus_MPa = 0.5;   ///< assumed: soft neoprene
  double prompt_share = 0.8;  ///< assumed
  double relaxation_s = 0.3;  ///< assumed; 0 for a foam that forgets at once

  /// Pressure for an indentation, kPa/mm.
  double stiffness() const { return 1000 * modulus_MPa / thickness_mm; }

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
/// f = x / tanh x, x = w / 2 L_T, and x^2 is proportional to p. Assumed is where the law passes:
/// by default ratio 10 at 10 N on a disc of radius 10 mm.
struct RisingLaw {
  double reference_pressure_kPa = 31.830988618379067;
  double reference_ratio = 10;

  bool operator==(const RisingLaw&) const = default;
};

using ContactLaw = std::variant<FallingLaw, RisingLaw>;

const char* name_of(const ContactLaw& law);  ///< "falling", "rising"

/// What lies on the sheet: foam with `patches` x `patches` square conductive patches, at equal
/// distances over the sheet and apart from each other. Pressure acts through the patches, so a
/// touch changes one conductivity for each patch, and between them nothing.
struct Skin {
  int patches = 24;       ///< along one side
  double patch_mm = 7.5;  ///< side of a patch, mm
  Foam foam;
  ContactLaw law;

  bool operator==(const Skin&) const = default;
};

/// Reads an object with the members' names as keys, every key but the "type" of "law" optional.
/// `side_mm`: of the sheet, on which the patches must have room.
Skin skin_from_json(JsonObject object, double side_mm);
nlohmann::json to_json(const Skin& skin);
nlohmann::ordered_json skin_schema();

}  // namespace ertbench
