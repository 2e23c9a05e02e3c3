#include "solvers/channel_mask.h"

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "core/errors.h"

namespace ertbench {

int size_of(ElectrodeSet electrodes) { return std::popcount(electrodes); }

std::vector<ElectrodeSet> electrode_sets_of_channels(const Sensor& sensor) {
  std::vector<ElectrodeSet> out;
  for (const auto& [drive, measurement] : electrodes_of_channels(sensor)) {
    out.push_back(ElectrodeSet{1} << drive.first | ElectrodeSet{1} << drive.second |
                  ElectrodeSet{1} << measurement.first | ElectrodeSet{1} << measurement.second);
  }
  return out;
}

std::vector<ElectrodeSet> electrodes_of_pairs(const Sensor& sensor) {
  const std::vector<ElectrodeSet> of_channels = electrode_sets_of_channels(sensor);
  std::vector<ElectrodeSet> out;
  for (const auto& pair : reciprocal_pairs(sensor)) {
    out.push_back(of_channels[static_cast<std::size_t>(pair[0])]);
  }
  return out;
}

std::vector<Eigen::Index> pairs_without(const Sensor& sensor, ElectrodeSet masked) {
  const std::vector<ElectrodeSet> electrodes = electrodes_of_pairs(sensor);
  std::vector<Eigen::Index> kept;
  for (std::size_t p = 0; p < electrodes.size(); ++p) {
    if ((electrodes[p] & masked) == 0) kept.push_back(static_cast<Eigen::Index>(p));
  }
  return kept;
}

std::vector<Eigen::Index> pairs_with(const Sensor& sensor, ElectrodeSet masked) {
  if (masked == 0) return {};
  return others(pairs_without(sensor, masked), std::ssize(reciprocal_pairs(sensor)));
}

std::vector<Eigen::Index> others(const std::vector<Eigen::Index>& some, Eigen::Index count) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!std::binary_search(some.begin(), some.end(), i)) out.push_back(i);
  }
  return out;
}

Eigen::MatrixXd columns_for_all_pairs(const Eigen::MatrixXd& columns,
                                      const std::vector<Eigen::Index>& kept, Eigen::Index pairs) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(columns.rows(), pairs);
  out(Eigen::all, kept) = columns;
  return out;
}

ParameterInfo ChannelMask::parameter() {
  return {
      "channel_mask",
      "channels left out of account: \"none\" (the default), a list of electrodes (from 0) whose "
      "channels are, or \"detect\": in each frame those of its dead electrodes"};
}

ChannelMask ChannelMask::from_json(JsonObject& object) {
  ChannelMask mask;
  mask.place_ =
      (object.source().empty() ? "" : object.source() + ": ") + object.path_of("channel_mask");
  if (!object.has("channel_mask")) return mask;
  const nlohmann::json& value = object.raw("channel_mask");
  if (value.is_string()) {
    mask.detect = object.choice("channel_mask", {"none", "detect"}) == "detect";
    return mask;
  }
  if (!value.is_array()) {
    object.fail("channel_mask",
                "must be \"none\", \"detect\" or a list of electrodes, got " + json_shown(value));
  }
  for (const int electrode : object.integers("channel_mask", 1, 59, {0, 63})) {
    mask.electrodes |= ElectrodeSet{1} << electrode;
  }
  return mask;
}

void ChannelMask::add_to(nlohmann::json& parameters) const {
  if (detect) {
    parameters["channel_mask"] = "detect";
  } else if (electrodes == 0) {
    parameters["channel_mask"] = "none";
  } else {
    parameters["channel_mask"] = nlohmann::json::array();
    for (int e = 0; e < 64; ++e) {
      if (electrodes >> e & 1) parameters["channel_mask"].push_back(e);
    }
  }
}

void ChannelMask::check(const Sensor& sensor) const {
  const int count = sensor.electrode_count;
  if (count < 64 && electrodes >> count != 0) {
    throw InputError(place_ + ": names an electrode that is not there: the sensor has " +
                     std::to_string(count) + ", 0 ... " + std::to_string(count - 1));
  }
  if (electrodes != 0 && count - size_of(electrodes) < 5) {
    throw InputError(place_ + ": must leave five electrodes or more, leaves " +
                     std::to_string(count - size_of(electrodes)));
  }
  if (electrodes != 0 && pairs_without(sensor, electrodes).empty()) {
    throw InputError(place_ + ": leaves no channel; every one of the sensor's uses one of these");
  }
}

Eigen::VectorXd Reciprocity::reduce(const Eigen::Ref<const Eigen::RowVectorXd>& frame) const {
  Eigen::VectorXd reduced(pairs());
  // Halved first, so that frames near the largest double do not overflow in the sum.
  for (Eigen::Index i = 0; i < pairs(); ++i) {
    const auto& [a, b] = pairs_[static_cast<std::size_t>(i)];
    reduced[i] = (frame[a] / 2 + frame[b] / 2) * of_mean(i);
  }
  return reduced;
}

double Reciprocity::noise(const Eigen::Ref<const Eigen::RowVectorXd>& frame,
                          const std::vector<Eigen::Index>& lost) const {
  double squares = 0;
  int count = 0;
  for (Eigen::Index p = 0; p < static_cast<Eigen::Index>(doubles_); ++p) {
    if (std::binary_search(lost.begin(), lost.end(), p)) continue;
    const auto& [a, b] = pair(p);
    squares += (frame[a] - frame[b]) * (frame[a] - frame[b]) / 2;
    ++count;
  }
  return count > 0 ? squares / count : 0;
}

Eigen::MatrixXd Reciprocity::reduce_rows(const RowMajorMatrix& jacobian) const {
  Eigen::MatrixXd reduced(pairs(), jacobian.cols());
  for (Eigen::Index i = 0; i < pairs(); ++i) {
    const auto& [a, b] = pairs_[static_cast<std::size_t>(i)];
    reduced.row(i) = (jacobian.row(a) + jacobian.row(b)) * (of_mean(i) / 2);
  }
  return reduced;
}

}  // namespace ertbench
