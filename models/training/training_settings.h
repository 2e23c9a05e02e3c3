#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "models/training/training_faults.h"

namespace ertbench {

class JsonObject;

/// How a network is trained; the architectures' own defaults differ.
struct TrainingSettings {
  std::uint64_t seed = 1;       ///< of the first weights, the order of the scenes and the noise
  int epochs = 20;              ///< at most
  int batch = 32;               ///< scenes a step
  double learning_rate = 2e-3;  ///< of Adam, its largest
  bool one_cycle = true;     ///< rises for a tenth of the steps, falls to nearly 0; else constant
  double slow_rate = 0.015;  ///< of the learning rate, for Network::slow_parameters
  /// Share of the steps after which batch normalisation stops looking at the batch and uses the
  /// statistics gathered so far, as it will when images are made.
  double freeze_statistics = 0.6;
  bool bfloat16 = false;       ///< compute in bfloat16 (ReducedPrecision), else float32
  bool symmetries = true;      ///< turn scenes by the symmetries of the sensor
  bool new_scenes = false;     ///< draw new scenes for every epoch
  int patience = 20;           ///< epochs without a better validation error before it ends early
  TrainingFaults faults = {};  ///< put into the frames, besides fresh noise

  /// Reads `{"seed", "epochs", "batch", "learning_rate", "schedule", "slow_rate",
  /// "freeze_statistics", "precision", "symmetries",
  /// "new_scenes", "patience"}` and what TrainingFaults reads; `defaults` stand for what is left
  /// out.
  static TrainingSettings from_json(JsonObject& object, const TrainingSettings& defaults);
};

nlohmann::json to_json(const TrainingSettings& settings);

}  // namespace ertbench
