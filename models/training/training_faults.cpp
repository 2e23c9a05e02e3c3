#include "models/training/training_faults.h"

#include <nlohmann/json.hpp>

#include "core/json_reader.h"

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

}  // namespace ertbench
