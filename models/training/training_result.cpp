#include "models/training/training_result.h"

#include <nlohmann/json.hpp>

namespace ertbench {

nlohmann::json to_json(const TrainingResult& result) {
  nlohmann::json out = {{"status", result.report.status},
                        {"message", result.report.message},
                        {"earlier_s", result.report.earlier_s},
                        {"epochs", result.epochs},
                        {"best_epoch", result.best_epoch},
                        {"validation_error", result.validation_error},
                        {"seconds", result.seconds}};
  if (!result.converged) out["converged"] = false;
  return out;
}

TrainingResult training_result_from_json(const nlohmann::json& json) {
  TrainingResult out;
  out.report = {json.at("status"), json.at("message"), json.value("earlier_s", 0.0)};
  out.epochs = json.at("epochs");
  out.best_epoch = json.at("best_epoch");
  out.converged = json.value("converged", true);
  out.validation_error = json.at("validation_error");
  out.seconds = json.at("seconds");
  return out;
}

}  // namespace ertbench
