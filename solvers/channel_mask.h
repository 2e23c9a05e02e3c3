#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/json_reader.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// A set of electrodes, bit e for electrode e; a sensor has at most 64.
using ElectrodeSet = std::uint64_t;

int size_of(ElectrodeSet electrodes);

/// The electrodes that each reciprocal pair drives or measures with, in the order of
/// `reciprocal_pairs`: both channels of a pair use the same ones.
std::vector<ElectrodeSet> electrodes_of_pairs(const Sensor& sensor);

/// The reciprocal pairs that use none of `masked`, ascending.
std::vector<Eigen::Index> pairs_without(const Sensor& sensor, ElectrodeSet masked);

/// Columns of the kept pairs -> columns of all `pairs`, zero where a pair is not kept.
Eigen::MatrixXd columns_for_all_pairs(const Eigen::MatrixXd& columns,
                                      const std::vector<Eigen::Index>& kept, Eigen::Index pairs);

/// Which channels a solver leaves out of account: `"channel_mask": "none"`, or a list of
/// electrodes, whose channels have weight zero in every frame, or `"detect"`: in each frame those
/// of the electrodes that FrameCheck finds dead.
struct ChannelMask {
  /// Frames with more dead electrodes than this are suspect even where they are masked.
  static constexpr int most_detected = 4;

  ElectrodeSet electrodes = 0;
  bool detect = false;

  static ChannelMask from_json(JsonObject& object);
  void add_to(nlohmann::json& parameters) const;
  /// Throws InputError where the list names electrodes that the sensor has not, or leaves fewer
  /// than five: the least that a sensor can have.
  void check(const Sensor& sensor) const;

 private:
  std::string place_;  ///< "a.json: /solvers/0/channel_mask"
};

}  // namespace ertbench
