#include "models/training/training_settings.h"

#include <nlohmann/json.hpp>

#include "core/json_reader.h"

namespace ertbench {

TrainingSettings TrainingSettings::from_json(JsonObject& object, const TrainingSettings& defaults) {
  TrainingSettings out;
  out.seed = static_cast<std::uint64_t>(
      object.integer_or("seed", static_cast<int>(defaults.seed), 0, 2147483647));
  out.epochs = object.integer_or("epochs", defaults.epochs, 1, 100000);
  out.batch = object.integer_or("batch", defaults.batch, 2, 65536);
  out.learning_rate = object.number_or("learning_rate", defaults.learning_rate, {0, 10, true});
  out.one_cycle = object.choice_or("schedule", defaults.one_cycle ? "one-cycle" : "constant",
                                   {"one-cycle", "constant"}) == "one-cycle";
  out.slow_rate = object.number_or("slow_rate", defaults.slow_rate, {0, 1});
  out.freeze_statistics = object.number_or("freeze_statistics", defaults.freeze_statistics, {0, 1});
  out.bfloat16 = object.choice_or("precision", defaults.bfloat16 ? "bfloat16" : "float32",
                                  {"float32", "bfloat16"}) == "bfloat16";
  out.symmetries = object.boolean_or("symmetries", defaults.symmetries);
  out.new_scenes = object.boolean_or("new_scenes", defaults.new_scenes);
  out.patience = object.integer_or("patience", defaults.patience, 1, 100000);
  out.faults = TrainingFaults::from_json(object);
  return out;
}

nlohmann::json to_json(const TrainingSettings& settings) {
  nlohmann::json out = {{"seed", settings.seed},
                        {"epochs", settings.epochs},
                        {"batch", settings.batch},
                        {"learning_rate", settings.learning_rate},
                        {"schedule", settings.one_cycle ? "one-cycle" : "constant"},
                        {"slow_rate", settings.slow_rate},
                        {"freeze_statistics", settings.freeze_statistics},
                        {"precision", settings.bfloat16 ? "bfloat16" : "float32"},
                        {"symmetries", settings.symmetries},
                        {"new_scenes", settings.new_scenes},
                        {"patience", settings.patience}};
  settings.faults.add_to(out);
  return out;
}

}  // namespace ertbench
