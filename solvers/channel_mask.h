#pragma once

#include <Eigen/Core>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <numbers>
#include <vector>

#include "core/arrays.h"
#include "core/json.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

int size_of(ElectrodeSet electrodes);

/// Electrodes that each channel drives or measures with.
std::vector<ElectrodeSet> electrode_sets_of_channels(const Sensor& sensor);
/// Electrodes that each reciprocal pair drives or measures with, in the order of
/// `reciprocal_pairs`; both channels of a pair use the same ones.
std::vector<ElectrodeSet> electrodes_of_pairs(const Sensor& sensor);

/// Reciprocal pairs that use none of `masked`, ascending.
std::vector<Eigen::Index> pairs_without(const Sensor& sensor, ElectrodeSet masked);

/// The other pairs, ascending.
std::vector<Eigen::Index> pairs_with(const Sensor& sensor, ElectrodeSet masked);
/// The indices 0 ... count - 1 that are not among `some`; both ascending.
std::vector<Eigen::Index> others(const std::vector<Eigen::Index>& some, Eigen::Index count);

/// Expands columns of the `kept` pairs to columns of all `pairs`, zero for the others.
Eigen::MatrixXd columns_for_all_pairs(const Eigen::MatrixXd& columns,
                                      const std::vector<Eigen::Index>& kept, Eigen::Index pairs);

/// The parameter "channel_mask" of solvers that can ignore channels: `"none"`; a list of
/// electrodes, whose channels have weight zero in every frame; or `"detect"`, which masks the dead
/// electrodes of each frame.
struct ChannelMask : MaskedChannels {
  static ParameterInfo parameter();

  static ChannelMask from_json(JsonObject& object);
  void add_to(nlohmann::json& parameters) const;
  /// Throws InputError if the list names electrodes that the sensor does not have, or leaves fewer
  /// than five (the minimum of a sensor) or no channel.
  void check(const Sensor& sensor) const;

 private:
  std::string place_;  ///< "a.json: /solvers/0/channel_mask"
};

/// Halves a linear problem by reciprocity. The two channels a, b of a reciprocal pair have the same
/// row in the Jacobian J, so that with J' = (J_a + J_b)/sqrt(2) and d' = (d_a + d_b)/sqrt(2)
///
///     |J x - d|^2 = |J' x - d'|^2 + sum (d_a - d_b)^2 / 2,
///
/// whose last term does not depend on the image. J' has the singular values of J, and J'^T J' =
/// J^T J.
///
/// A channel without a partner (see reciprocal_pairs) is a pair of its own, {c, c}, with J' = J_c
/// and d' = d_c.
class Reciprocity {
 public:
  Reciprocity() = default;
  explicit Reciprocity(const Sensor& sensor)
      : pairs_(reciprocal_pairs(sensor)),
        doubles_(static_cast<std::size_t>(sensor.channels()) - pairs_.size()) {}

  Eigen::Index pairs() const { return static_cast<Eigen::Index>(pairs_.size()); }

  Eigen::Index channels() const { return pairs() + static_cast<Eigen::Index>(doubles_); }
  /// True if every channel is a pair of its own.
  bool single() const { return doubles_ == 0; }
  /// d' over the mean of a pair's channels: sqrt(2), 1 for a single channel.
  double of_mean(Eigen::Index pair) const { return is_double(pair) ? std::numbers::sqrt2 : 1; }

  /// The two channels of a pair.
  const std::array<int, 2>& pair(Eigen::Index index) const {
    return pairs_[static_cast<std::size_t>(index)];
  }

  /// Sums d_a + d_b = sqrt(2) d' of the pairs of one frame; `frame` [channels] and `sums` [pairs]
  /// are contiguous.
  template <typename Scalar>
  void sum(const double* frame, Scalar* sums) const {
    for (std::size_t i = 0; i < doubles_; ++i) {
      *sums++ = static_cast<Scalar>(frame[pairs_[i][0]] + frame[pairs_[i][1]]);
    }
    for (std::size_t i = doubles_; i < pairs_.size(); ++i) {
      *sums++ = static_cast<Scalar>(std::numbers::sqrt2 * frame[pairs_[i][0]]);
    }
  }
  /// d' of one frame [channels] -> [pairs].
  Eigen::VectorXd reduce(const Eigen::Ref<const Eigen::RowVectorXd>& frame) const;
  /// Variance of a channel by noise, V^2, from the differences of the pairs of two that are not
  /// among `lost`, ascending; 0 without such a pair.
  double noise(const Eigen::Ref<const Eigen::RowVectorXd>& frame,
               const std::vector<Eigen::Index>& lost) const;
  /// J' of J: [channels, n] -> [pairs, n].
  Eigen::MatrixXd reduce_rows(const RowMajorMatrix& jacobian) const;

 private:
  bool is_double(Eigen::Index pair) const { return static_cast<std::size_t>(pair) < doubles_; }

  std::vector<std::array<int, 2>> pairs_;
  std::size_t doubles_ = 0;  ///< pairs of two channels, which come first
};

}  // namespace ertbench
