#include "forward/sheet/skin.h"

#include <nlohmann/json.hpp>

#include "core/json_reader.h"

namespace ertbench {
namespace {

Foam foam_from_json(JsonObject object) {
  Foam foam;
  foam.thickness_mm = object.number_or("thickness_mm", foam.thickness_mm, {0.01, 1000, false});
  foam.modulus_MPa = object.number_or("modulus_MPa", foam.modulus_MPa, {1e-6, 1e6, false});
  foam.prompt_share = object.number_or("prompt_share", foam.prompt_share, {0, 1});
  foam.relaxation_s = object.number_or("relaxation_s", foam.relaxation_s, {0, 1e6, false, "s"});
  object.finish();
  return foam;
}

ContactLaw law_from_json(JsonObject object) {
  ContactLaw law;
  const Range pressure{1e-6, 1e9, false, "kPa"};
  if (object.choice("type", {"falling", "rising"}) == "falling") {
    FallingLaw falling;
    falling.depth = object.number_or("depth", falling.depth, {0, 0.999, true});
    falling.half_pressure_kPa =
        object.number_or("half_pressure_kPa", falling.half_pressure_kPa, pressure);
    law = falling;
  } else {
    RisingLaw rising;
    rising.reference_pressure_kPa =
        object.number_or("reference_pressure_kPa", rising.reference_pressure_kPa, pressure);
    rising.reference_ratio =
        object.number_or("reference_ratio", rising.reference_ratio, {1, 1000, true});
    law = rising;
  }
  object.finish();
  return law;
}

}  // namespace

const char* name_of(const ContactLaw& law) {
  return std::holds_alternative<FallingLaw>(law) ? "falling" : "rising";
}

Skin skin_from_json(JsonObject object, double side_mm) {
  Skin skin;
  skin.patches = object.integer_or("patches", skin.patches, 1, 96);
  const double pitch = side_mm / skin.patches;
  skin.patch_mm = object.number_or("patch_mm", 0.9 * pitch, {0, pitch * (1 + 1e-9), true, "mm"});
  if (object.has("foam")) skin.foam = foam_from_json(object.object("foam"));
  if (object.has("law")) skin.law = law_from_json(object.object("law"));
  object.finish();
  return skin;
}

nlohmann::json to_json(const Skin& skin) {
  nlohmann::json law = {{"type", name_of(skin.law)}};
  if (const auto* falling = std::get_if<FallingLaw>(&skin.law)) {
    law["depth"] = falling->depth;
    law["half_pressure_kPa"] = falling->half_pressure_kPa;
  } else {
    const auto& rising = std::get<RisingLaw>(skin.law);
    law["reference_pressure_kPa"] = rising.reference_pressure_kPa;
    law["reference_ratio"] = rising.reference_ratio;
  }
  return {{"patches", skin.patches},
          {"patch_mm", skin.patch_mm},
          {"foam",
           {{"thickness_mm", skin.foam.thickness_mm},
            {"modulus_MPa", skin.foam.modulus_MPa},
            {"prompt_share", skin.foam.prompt_share},
            {"relaxation_s", skin.foam.relaxation_s}}},
          {"law", law}};
}

}  // namespace ertbench
