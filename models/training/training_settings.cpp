#include "models/training/training_settings.h"

#include <nlohmann/json.hpp>

#include "core/json.h"

namespace ertbench {

Faults TrainingFaults::draw(RandomStream& random) const {
  Faults faults;
  if (random.uniform() >= share) return faults;
  faults.dead_electrodes = random.integer(dead_electrodes.first, dead_electrodes.second);
  faults.dead_reading = dead_reading;
  faults.gain_error = random.uniform(gain_error.first, gain_error.second);
  faults.offset = random.uniform(offset.first, offset.second);
  return faults;
}

TrainingFaults TrainingFaults::from_json(JsonObject& object) {
  TrainingFaults out;
  if (!object.has("training_faults")) {
    if (object.has("fault_share")) {
      object.fail("fault_share", "stands without \"training_faults\"; add them or remove it");
    }
    return out;
  }
  JsonObject faults = object.object("training_faults");
  // The least sensor has five electrodes; ChannelMask leaves as many.
  if (faults.has("dead_electrodes")) {
    out.dead_electrodes = faults.integer_interval("dead_electrodes", 0, 59);
  }
  if (faults.choice_or("dead_reading", "zero", {"zero", "floating"}) == "floating") {
    out.dead_reading = DeadReading::floating;
  }
  if (faults.has("gain_error")) out.gain_error = faults.interval("gain_error", {0, 10});
  if (faults.has("offset")) out.offset = faults.interval("offset", {0, 10});
  faults.finish();
  out.share = object.number_or("fault_share", out.share, {0, 1, true});
  if (!out) object.fail("training_faults", "has no fault above zero; give one or remove it");
  return out;
}

void TrainingFaults::add_to(nlohmann::json& settings) const {
  if (!*this) return;
  settings["training_faults"] = {
      {"dead_electrodes", dead_electrodes},
      {"dead_reading", dead_reading == DeadReading::zero ? "zero" : "floating"},
      {"gain_error", gain_error},
      {"offset", offset}};
  settings["fault_share"] = share;
}

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
