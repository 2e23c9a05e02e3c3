#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "forward/data/faults.h"

namespace ertbench {

/// Faults in the frames of a training, drawn anew for every frame of every epoch. A share of the
/// frames has those of the electronics, and the same share, each drawn by itself, those of the
/// sheet; sizes are uniform in these intervals.
struct TrainingFaults {
  std::pair<int, int> dead_electrodes{0, 0};
  DeadReading dead_reading = DeadReading::zero;
  std::pair<double, double> gain_error{0, 0};
  std::pair<double, double> offset{0, 0};
  // Sheet, since the reference was taken; to first order but for the level.
  std::pair<double, double> level{0, 0};         ///< relative change of the conductivity
  std::pair<double, double> gradient{0, 0};      ///< as Faults::background_gradient
  std::pair<double, double> displacement{0, 0};  ///< as Faults::electrode_displacement
  /// SNR of every frame, dB, in place of the training set's noise.
  std::optional<std::pair<double, double>> snr_db;
  double share = 0.5;  ///< of the frames, "fault_share"

  bool of_electronics() const {
    return dead_electrodes.second > 0 || gain_error.second > 0 || offset.second > 0;
  }
  bool of_sheet() const {
    return level != std::pair{0.0, 0.0} || gradient.second > 0 || displacement.second > 0;
  }
  /// Whether there are any.
  explicit operator bool() const {
    return share > 0 && (of_electronics() || of_sheet() || snr_db.has_value());
  }

  /// Draws the faults of one frame; frames outside the share have none.
  Faults draw(RandomStream& random) const;
};

class Fields;

/// Settings of a training; each architecture has its own defaults.
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
  bool bfloat16 = false;        ///< compute in bfloat16 (ReducedPrecision), else float32
  std::string device = "auto";  ///< training_device; the fits of all devices are one
  bool symmetries = true;       ///< turn scenes by the symmetries of the sensor
  bool new_scenes = false;      ///< draw new scenes for every epoch
  int patience = 20;            ///< epochs without a better validation error before it ends early
  TrainingFaults faults = {};   ///< put into the frames, besides fresh noise
};

/// "seed", "epochs", "batch", "learning_rate", "schedule", "slow_rate", "freeze_statistics",
/// "precision", "device" (only read), "symmetries", "new_scenes", "patience"; "training_faults" and
/// "fault_share", which are written where there are any, so that networks trained without them are
/// what they were.
void visit(Fields& fields, TrainingSettings& settings);

}  // namespace ertbench
