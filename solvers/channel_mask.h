#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/json_reader.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

int size_of(ElectrodeSet electrodes);

/// The electrodes that each reciprocal pair drives or measures with, in the order of
/// `reciprocal_pairs`: both channels of a pair use the same ones.
std::vector<ElectrodeSet> electrodes_of_pairs(const Sensor& sensor);

/// The reciprocal pairs that use none of `masked`, ascending.
std::vector<Eigen::Index> pairs_without(const Sensor& sensor, ElectrodeSet masked);

/// Columns of the kept pairs -> columns of all `pairs`, zero where a pair is not kept.
Eigen::MatrixXd columns_for_all_pairs(const Eigen::MatrixXd& columns,
                                      const std::vector<Eigen::Index>& kept, Eigen::Index pairs);

/// The parameter "channel_mask" of solvers that can leave channels out of account: `"none"`, or a
/// list of electrodes, whose channels have weight zero in every frame, or `"detect"`: in each frame
/// those of its dead electrodes.
struct ChannelMask : MaskedChannels {
  static ParameterInfo parameter();

  static ChannelMask from_json(JsonObject& object);
  void add_to(nlohmann::json& parameters) const;
  /// Throws InputError where the list names electrodes that the sensor has not, or leaves fewer
  /// than five: the least that a sensor can have, or no channel.
  void check(const Sensor& sensor) const;

 private:
  std::string place_;  ///< "a.json: /solvers/0/channel_mask"
};

}  // namespace ertbench
