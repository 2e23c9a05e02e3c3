#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

#include "forward/sheet/sensor.h"
#include "solvers/channel_mask.h"
#include "solvers/solver.h"

namespace ertbench {

/// The value that `share` of the frames like these are above: the quantile of the generalised
/// Pareto tail that the farthest tenth of `values` (all >= 0) has by the moments of its logarithms
/// (Dekkers, Einmahl and de Haan, Ann. Statist. 17, 1989), be it heavy or bounded; and where the
/// tail has a lump, no less than the quantile of the values themselves. It takes some hundred
/// values to mean anything; of one value, or of equal ones, it is the largest. Throws
/// std::invalid_argument where there is none.
double tail_limit(Eigen::VectorXd values, double share);

/// What is usual for a mean square q beside a signal whose square is s: q = a + b s, which covers
/// noise of a fixed level, noise of a fixed ratio to the signal, and what a model leaves of it.
struct UsualLevel {
  double a = 0;
  double b = 0;
  double limit = 0;  ///< of q / (a + b s)

  /// From the q and s of frames. `floor`: the least a, beside what a converter resolves. One frame
  /// is its own level, with limit 1. Throws std::invalid_argument where there is no frame.
  static UsualLevel of(const Eigen::VectorXd& q, const Eigen::VectorXd& s, double floor,
                       double share);
  double relative(double q, double s) const { return q / (a + b * s); }
};

/// The principal directions of frames that stand above the noise, and how they vary along them.
struct PrincipalDirections {
  static constexpr Eigen::Index most = 32;

  Eigen::VectorXd mean;           ///< [inputs]
  Eigen::MatrixXd rows;           ///< [directions, inputs], orthonormal
  Eigen::VectorXd inverse_power;  ///< [directions], one over the variances
  /// [directions]: of all linear functions of a frame the one whose mean is largest beside its
  /// scatter (Fisher's). Frames that are the negative of such as these have the wrong sign of it.
  Eigen::VectorXd tilt;

  /// `frames` [frames, inputs]; directions with at least twice the variance `noise`, one for every
  /// four frames at most: fewer than four have a mean and no directions. Throws
  /// std::invalid_argument where there is no frame.
  static PrincipalDirections of(const Eigen::MatrixXd& frames, double noise);

  struct Place {
    double outside;   ///< the square of what the directions do not explain
    double distance;  ///< the square of the Mahalanobis distance within them
    double along;     ///< along `tilt`, from the mean's
  };
  /// `centred`: a frame less the mean.
  template <typename Vector>
  Place place(const Vector& centred) const {
    using Scores = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
    Scores scores;
    scores.noalias() = rows * centred;
    return {std::max(0.0, centred.squaredNorm() - scores.squaredNorm()),
            scores.cwiseAbs2().dot(inverse_power), scores.dot(tilt)};
  }
};

/// What the voltages alone tell of whether a frame is one to trust, the same for every solver.
///
/// - Dead electrodes: nearly all channels (22 of 26 pairs) that use one read under a tenth of their
///   reference voltage; or, floating, are unlike their reciprocal ones, by over three times the
///   usual noise, while the rest of the frame has no more than that.
/// - Noise: the two channels of a reciprocal pair see the same signal, so that their difference
///   (d_a - d_b)/sqrt(2) is noise alone (or a fault that breaks reciprocity: gain, offset).
/// - Range, of the pairs' means d' = (d_a + d_b)/sqrt(2): their size; and of their shape, d' over
///   its size (a little more, so that noise alone has none), how much lies outside the principal
///   directions of the frames it was fitted on, how far out it is within them (Mahalanobis), and
///   how like an even change of the whole sheet it is (along the reference voltages, both ways).
///   Not looked at where an electrode is dead or the noise is too high.
///
/// Fitted on up to 4096 frames of the validation set, of the training set where there is none. Six
/// limits (noise, size, outside, distance, and both ends of the tilt) are each put where one frame
/// in 1200 of that kind is beyond (tail_limit), so that together about one good frame in 200 raises
/// a false alarm. What the directions leave is judged on frames that had no part in finding them.
/// With fewer than 100 frames, or none, only electrodes that read zero are found.
class FrameCheck {
 public:
  /// Frames with more dead electrodes than this are suspect even where they are masked.
  static constexpr int most_masked = 4;

  struct Verdict {
    std::uint8_t reasons = 0;  ///< of FrameReason
    /// The fewest electrodes that explain it: between two dead ones a third cannot be told from
    /// a live one, and has no channel that could be used.
    ElectrodeSet dead = 0;
  };

  /// Finds nothing.
  FrameCheck() = default;
  /// Finds electrodes that read zero; `masked` ones are left out of account.
  FrameCheck(const Sensor& sensor, ElectrodeSet masked);
  /// Throws InputError where the frames are of another sensor.
  FrameCheck(const FitInput& input, ElectrodeSet masked);
  /// What `packed` gave. Throws std::invalid_argument where it is not that.
  FrameCheck(const Sensor& sensor, ElectrodeSet masked, const Eigen::VectorXd& packed);

  /// Whether noise and range have limits: it was fitted, and on enough frames.
  bool has_limits() const { return noise_.limit > 0; }
  /// All of it in one vector, for the file of a fitted solver.
  Eigen::VectorXd packed() const;

  /// One frame [channels], contiguous: V, change from the reference. One that is not finite has an
  /// empty verdict: its status is undefined anyhow.
  Verdict judge(const double* change) const;
  /// Puts a verdict into the report of a frame. `masked`: the channels of the dead electrodes were
  /// left out of its image. The status that the solver itself reported takes precedence, but for a
  /// frame that did not converge with a dead electrode: it is suspect.
  static void report(const Verdict& verdict, bool masked, FrameReport& report);

 private:
  void set_sensor(const Sensor& sensor, ElectrodeSet masked);
  void set_reference(const Eigen::VectorXd& reference);
  void fit(const Frames& changes);
  /// d' of the pairs into `means`; returns half the squares of the pairs' differences.
  double split(const double* change, double* means) const;
  template <typename Vector>
  void judge_pairs(const double* change, Vector& means, Verdict& verdict) const;
  ElectrodeSet reading_zero(const double* change) const;
  /// Usual mean square of a pair's difference, V^2, beside pairs whose squares add up to `signal`.
  double usual_noise(double signal) const;
  ElectrodeSet floating(const double* change, double signal) const;
  /// Whether the noise is above the usual in the pairs that use none of `dead`; true where there
  /// are fewer than `least`.
  bool noisy_without(const double* change, ElectrodeSet dead, int least) const;
  /// Electrodes nearly all of whose pairs are bad.
  template <typename Bad>
  ElectrodeSet with_bad_pairs(Bad&& bad) const;
  ElectrodeSet fewest(ElectrodeSet dead) const;

  int electrode_count_ = 0;
  int channels_of_pair_ = 2;                   ///< 1 where channels have no reciprocal partner
  bool drives_neighbours_ = true;              ///< by adjacent pairs
  std::vector<std::array<int, 2>> pairs_;      ///< channels of the pairs that are not masked
  std::vector<ElectrodeSet> pair_electrodes_;  ///< of these pairs
  std::vector<int> least_bad_;                 ///< of each electrode's pairs, where it is dead
  int fewest_bad_ = 0;                         ///< the least of these
  Eigen::ArrayXd reference_;                   ///< [channels] V
  Eigen::ArrayXd nearly_zero_;                 ///< [channels] V
  Eigen::VectorXd along_reference_;            ///< [pairs], of length 1

  double reference_size_ = 0;  ///< of the pairs' means, V

  /// Of the pairs' differences, beside the frame's or its change's square, whichever it follows
  /// more closely; its limit is 0 where nothing is fitted.
  UsualLevel noise_;
  bool noise_of_change_ = false;
  UsualLevel outside_;              ///< V^2, beside the change's square
  PrincipalDirections directions_;  ///< of the shapes
  double least_size_ = 0;           ///< square of what is added to a change's size, V^2
  double largest_ = 0;              ///< square of a change's size, V^2
  double farthest_ = 0;             ///< square of the Mahalanobis distance
  double lowest_ = 0;               ///< shape along the tilt
  double highest_ = 0;
};

}  // namespace ertbench
