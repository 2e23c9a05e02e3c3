#include "solvers/linear/linear_inference.h"

#include <nlohmann/json.hpp>

namespace ertbench {

std::vector<ParameterInfo> LinearInference::registered() {
  return {{"inference_precision",
           "of the product for a frame, \"float64\" (the default) or \"float32\"",
           ParameterRole::inference},
          {"inference_averaging",
           "add the two channels of a reciprocal pair first, which halves the matrix and is exact; "
           "default true",
           ParameterRole::inference}};
}

LinearInference LinearInference::from_json(JsonObject& object) {
  LinearInference out;
  out.single_precision =
      object.choice_or("inference_precision", "float64", {"float64", "float32"}) == "float32";
  out.averaging = object.boolean_or("inference_averaging", out.averaging);
  return out;
}

void LinearInference::add_to(nlohmann::json& parameters) const {
  parameters["inference_precision"] = single_precision ? "float32" : "float64";
  parameters["inference_averaging"] = averaging;
}

}  // namespace ertbench
