#include "solvers/linear/linear_inference.h"

#include <nlohmann/json.hpp>

namespace ertbench {

LinearInference LinearInference::from_json(JsonObject& object) {
  LinearInference out;
  out.single_precision =
      object.choice_or("inference_precision", "float64", {"float64", "float32"}) == "float32";
  out.averaging = object.boolean_or("inference_averaging", out.averaging);
  out.check = object.boolean_or("inference_check", out.check);
  return out;
}

void LinearInference::add_to(nlohmann::json& parameters) const {
  parameters["inference_precision"] = single_precision ? "float32" : "float64";
  parameters["inference_averaging"] = averaging;
  parameters["inference_check"] = check;
}

}  // namespace ertbench
