#pragma once

#include <nlohmann/json_fwd.hpp>
#include <utility>

#include "forward/data/faults.h"

namespace ertbench {

/// Faults of the electronics that a network meets while it is trained, drawn afresh for every frame
/// of every epoch: a share of the frames has them, each with sizes uniform in these intervals.
struct TrainingFaults {
  std::pair<int, int> dead_electrodes{0, 0};
  DeadReading dead_reading = DeadReading::zero;
  std::pair<double, double> gain_error{0, 0};
  std::pair<double, double> offset{0, 0};
  double share = 0.5;  ///< of the frames, "fault_share"

  /// Whether there are any.
  explicit operator bool() const {
    return share > 0 && (dead_electrodes.second > 0 || gain_error.second > 0 || offset.second > 0);
  }

  /// The faults of one frame; none for those that are spared.
  Faults draw(RandomStream& random) const;

  /// Reads `"training_faults": {"dead_electrodes", "dead_reading", "gain_error", "offset"}`, as in
  /// the "faults" of a dataset but with intervals for sizes, and `"fault_share"`.
  static TrainingFaults from_json(JsonObject& object);
  /// The same two keys; nothing where there are no faults, so that networks trained without them
  /// are what they were.
  void add_to(nlohmann::json& settings) const;
};

}  // namespace ertbench
