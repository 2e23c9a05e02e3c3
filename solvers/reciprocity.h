#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Halves a linear problem by reciprocity. The two channels a, b of a reciprocal pair have the same
/// row in the Jacobian J, so that with J' = (J_a + J_b)/sqrt(2) and d' = (d_a + d_b)/sqrt(2)
///
///     |J x - d|^2 = |J' x - d'|^2 + sum (d_a - d_b)^2 / 2,
///
/// whose last term no image can change. J' has the singular values of J, and J'^T J' = J^T J.
///
/// Of a sensor whose channels have no partners (see reciprocal_pairs) every channel is a pair of
/// its own, {c, c}, with J' = J_c and d' = d_c.
class Reciprocity {
 public:
  Reciprocity() = default;
  explicit Reciprocity(const Sensor& sensor)
      : pairs_(reciprocal_pairs(sensor)), single_(!is_reciprocal(sensor)) {}

  Eigen::Index pairs() const { return static_cast<Eigen::Index>(pairs_.size()); }

  Eigen::Index channels() const { return single_ ? pairs() : 2 * pairs(); }
  /// Whether every channel is a pair of its own.
  bool single() const { return single_; }

  /// The two channels of a pair.
  const std::array<int, 2>& pair(Eigen::Index index) const {
    return pairs_[static_cast<std::size_t>(index)];
  }

  /// sqrt(2) d', d_a + d_b, of every pair of one frame; `frame` [channels] and `sums` [pairs] lie
  /// contiguous.
  template <typename Scalar>
  void sum(const double* frame, Scalar* sums) const {
    if (single_) {
      for (const auto& pair : pairs_) {
        *sums++ = static_cast<Scalar>(std::numbers::sqrt2 * frame[pair[0]]);
      }
      return;
    }
    for (const auto& [a, b] : pairs_) *sums++ = static_cast<Scalar>(frame[a] + frame[b]);
  }
  /// d' of one frame [channels] -> [pairs].
  Eigen::VectorXd reduce(const Eigen::Ref<const Eigen::RowVectorXd>& frame) const;
  /// J' of J: [channels, n] -> [pairs, n].
  Eigen::MatrixXd reduce_rows(const RowMajorMatrix& jacobian) const;

 private:
  std::vector<std::array<int, 2>> pairs_;
  bool single_ = false;
};

}  // namespace ertbench
