#pragma once

#include <nlohmann/json_fwd.hpp>
#include <variant>

namespace ertbench {

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

/// Reads `{"patches", "patch_mm", "foam": {"thickness_mm", "modulus_MPa", "prompt_share",
/// "relaxation_s"}, "law": {"type": "falling", "depth", "half_pressure_kPa"} or {"type": "rising",
/// "reference_pressure_kPa", "reference_ratio"}}`, every key but the law's type optional.
/// `side_mm`: of the sheet, on which the patches must have room.
Skin skin_from_json(JsonObject object, double side_mm);
nlohmann::json to_json(const Skin& skin);

}  // namespace ertbench
