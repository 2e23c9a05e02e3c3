#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "core/frame_front.h"
#include "forward/sheet/sensor.h"
#include "solvers/channel_mask.h"
#include "solvers/solver.h"

namespace ertbench {

/// The value that a fraction `share` of such frames exceeds. It is the quantile of a generalised
/// Pareto tail, heavy or bounded, fitted to the largest tenth of `values` (all >= 0) by the moments
/// of their logarithms (Dekkers, Einmahl and de Haan, Ann. Statist. 17, 1989), and at least the
/// quantile of the values themselves. Needs some hundred values.
/// If all values are equal it is that value. Throws std::invalid_argument without a value.
double tail_limit(Eigen::VectorXd values, double share);

/// Usual mean square q for a signal of square s: q = a + b s. Covers noise of a fixed level, noise
/// proportional to the signal, and residuals of a model.
struct UsualLevel {
  double a = 0;
  double b = 0;
  double limit = 0;  ///< of q / (a + b s)

  /// Fits to the q and s of frames. `floor` is the least a, such as the resolution of a converter.
  /// One frame is its own level, with limit 1. Throws std::invalid_argument for none.
  static UsualLevel of(const Eigen::VectorXd& q, const Eigen::VectorXd& s, double floor,
                       double share);
  double relative(double q, double s) const { return q / (a + b * s); }
};

/// Principal directions of frames above the noise, with the variances along them.
struct PrincipalDirections {
  static constexpr Eigen::Index most = 32;

  Eigen::VectorXd mean;           ///< [inputs]
  Eigen::MatrixXd rows;           ///< [directions, inputs], orthonormal
  Eigen::VectorXd inverse_power;  ///< [directions], one over the variances
  /// [directions]: Fisher's linear function, whose mean is largest relative to its scatter. It
  /// changes its sign for negated frames.
  Eigen::VectorXd tilt;

  /// `frames` [frames, inputs]. Keeps directions with at least twice the variance `noise`.
  /// At most one direction for every four frames. Throws std::invalid_argument for no frame.
  static PrincipalDirections of(const Eigen::MatrixXd& frames, double noise);

  struct Place {
    double outside;   ///< square of the residual outside the directions
    double distance;  ///< square of the Mahalanobis distance within them
    double along;     ///< along `tilt`, relative to the mean
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

/// Flags frames that should not be trusted, from their voltages alone and independent of the
/// solver.
///
/// - Dead electrodes: nearly all channels of an electrode (22 of 26 pairs) either read less than a
///   tenth of their reference voltage or, if it floats, differ from their reciprocal channels by
///   more than three times the usual noise while the rest does not. Else up to four loose ones:
///   those in all pairs, but for two, of which one channel alone reads less than that tenth. Else
///   up to four half-dead ones: those in all pairs, but for six, that read between a quarter and
///   three quarters of their reference, if one factor explains their readings, given the others.
/// - Noise: the two channels of a reciprocal pair have the same signal, so that their difference
///   (d_a - d_b)/sqrt(2) is noise, or a fault that breaks reciprocity (gain, offset).
/// - Range, of the pairs' means d' = (d_a + d_b)/sqrt(2): their size, and four properties of their
///   shape d' / size (with a little added to the size, so that noise alone has no shape): the
///   residual outside the principal directions of the frames of the fit, the Mahalanobis distance
///   within them, and the similarity to an even change of the whole sheet (along the reference
///   voltages) in either sense. Skipped if an electrode is dead or the noise is too high.
///
/// Fitted on up to 4096 frames of the validation set, or of the training set without one. Each of
/// the six limits (noise, size, outside, distance, and both ends of the tilt) is exceeded by one
/// good frame in 1200 (tail_limit), so that together about one good frame in 200 raises a false
/// alarm. Residuals are judged on frames that did not determine the directions. With fewer than 100
/// frames only electrodes that read zero are detected.
class FrameCheck {
 public:
  /// Frames with more dead electrodes than this are flagged even if those are masked.
  static constexpr int most_masked = 4;

  struct Verdict {
    std::uint8_t reasons = 0;  ///< set of FrameReason
    /// The fewest electrodes that explain the frame: one between two dead electrodes cannot be
    /// distinguished from a live one, and has no usable channel anyway.
    ElectrodeSet dead = 0;
    /// The dead electrodes read this share of their voltages too little; 0 if they read anything
    /// else.
    double lost_share = 0;
    /// Contacts are loose: channels that read zero are bad, others are not. If nobody can tell
    /// whose they are, no electrode is dead.
    bool torn = false;

    /// Electrodes without a usable channel.
    ElectrodeSet lost() const { return torn ? 0 : dead; }
    /// True if there is something to impute.
    bool has_gaps() const { return torn || dead != 0; }
  };

  /// Flags nothing.
  FrameCheck() = default;
  /// Detects electrodes that read zero; ignores `masked` ones.
  FrameCheck(const Sensor& sensor, ElectrodeSet masked);
  /// Fits to frames. Throws InputError if they are of another sensor.
  FrameCheck(const FitInput& input, ElectrodeSet masked);
  /// Restores the result of `packed`. Throws std::invalid_argument for anything else.
  FrameCheck(const Sensor& sensor, ElectrodeSet masked, const Eigen::VectorXd& packed);

  /// From now on flags noise and range beyond those of `changes` [frames, channels], V, which may
  /// have faults. Detects and imputes dead electrodes as before. Does nothing without a fit, or
  /// with fewer than 100 frames.
  void widen(const Frames& changes);
  /// True if noise and range have limits: the check was fitted on enough frames.
  bool has_limits() const { return noise_.limit > 0; }
  /// All numbers in one vector, for the file of a fitted solver.
  Eigen::VectorXd packed() const;

  /// Judges one frame [channels], contiguous: V, change from the reference. The verdict on a frame
  /// that is not finite is empty; its status is undefined anyway.
  Verdict judge(const double* change) const;
  /// Enters a verdict into the report of a frame. `masked`: the image does not use the channels of
  /// the dead electrodes. A status of the solver takes precedence, except that a frame with a dead
  /// electrode that did not converge becomes suspect.
  static void report(const Verdict& verdict, bool masked, FrameReport& report);
  /// Replaces the channels of the `dead` electrodes in a frame [channels], contiguous, by their
  /// mean given the others, if frames are Gaussian with the second moments of those of the fit at
  /// the frame's own size. Leaves the frame as it is without a fit (has_limits) or with fewer than
  /// twelve pairs left.
  void impute(double* change, ElectrodeSet dead) const;
  /// As above for what the verdict on the frame calls lost.
  void impute(double* change, const Verdict& verdict) const;
  /// As above for the channels that are not among `kept`. One whose reciprocal channel is kept gets
  /// the value of that.
  void impute(double* change, const std::vector<int>& kept) const;

  /// Second moments of shapes, factors factors^T, and what they leave of a frame: its square is
  /// residual + residual_of_square |d'|^2, V^2.
  struct Shapes {
    Eigen::MatrixXd factors;  ///< [pairs, 1 + directions]
    double least_size = 0;    ///< square of what is added to a change's size, V^2
    double residual = 0;
    double residual_of_square = 0;
  };
  /// Only after a fit (has_limits).
  Shapes shapes() const;
  /// What is done with a frame before its image, as data, which tells nothing. Likewise.
  FrameFront front(const Sensor& sensor) const;
  /// d' of the pairs that are not masked into `out`; `change` [channels], contiguous.
  void means(const double* change, double* out) const { split(change, out); }
  /// Half the squares of the differences of the pairs of two without the `dead` electrodes, and the
  /// number of these pairs.
  std::pair<double, int> differences(const double* change, ElectrodeSet dead) const;
  /// Electrodes whose channels read less than a tenth of the reference.
  ElectrodeSet reading_zero(const double* change) const;

 private:
  static constexpr int least_pairs = 12;  ///< that can be asked for their noise, or for others
  static double square(double x) { return x * x; }

  void set_sensor(const Sensor& sensor, ElectrodeSet masked);
  void set_reference(const Eigen::VectorXd& reference);
  void fit(const Frames& changes);
  /// d' of the pairs into `means`; returns half the squares of the pairs' differences.
  double split(const double* change, double* means) const;
  template <typename Vector>
  void judge_pairs(const double* change, Vector& means, Verdict& verdict) const;
  /// Usual mean square of the difference of a pair of two, V^2, for pairs whose squares add up to
  /// `signal`.
  double usual_noise(double signal) const;
  ElectrodeSet floating(const double* change, double signal) const;
  /// Names the electrodes of the pairs of which one channel alone reads zero.
  /// `usual`: usual_noise of the frame.
  void find_loose(const double* change, double usual, Verdict& verdict) const;
  /// `means` [pairs]: d' of the frame.
  void find_half_dead(const Eigen::Ref<const Eigen::VectorXd>& means, Verdict& verdict) const;
  /// `means` of the frame with the lost pairs replaced by their mean given the others; false if too
  /// few are left.
  bool condition(Eigen::Ref<Eigen::VectorXd> means, const std::vector<bool>& lost) const;
  /// True if the pairs' means, which are overwritten, are out of range; `signal`: their square.
  template <typename Vector>
  bool out_of_range_of(Vector& means, double signal) const;
  /// True if the noise is above the usual in the pairs without the `dead` electrodes, or if there
  /// are fewer than `least` such pairs.
  bool noisy_without(const double* change, ElectrodeSet dead, int least) const;
  /// Electrodes nearly all of whose pairs are bad.
  template <typename Bad>
  ElectrodeSet with_bad_pairs(Bad&& bad) const;
  ElectrodeSet fewest(ElectrodeSet dead) const;
  void impute_pairs(double* change, const std::vector<bool>& lost) const;

  int electrode_count_ = 0;
  int doubles_ = 0;                            ///< pairs of two channels, which can tell noise
  bool drives_neighbours_ = true;              ///< by adjacent pairs
  std::vector<std::array<int, 2>> pairs_;      ///< channels of the pairs that are not masked
  std::vector<ElectrodeSet> pair_electrodes_;  ///< of these pairs
  std::vector<int> least_bad_;                 ///< bad pairs at which an electrode is dead
  int fewest_bad_ = 0;                         ///< minimum of least_bad_
  Eigen::ArrayXd reference_;                   ///< [channels] V
  Eigen::ArrayXd nearly_zero_;                 ///< [channels] V
  Eigen::VectorXd along_reference_;            ///< [pairs], of length 1

  double reference_size_ = 0;  ///< of the pairs' means, V

  /// Noise in the pairs' differences as a function of the square of the frame or of its change,
  /// whichever it follows more closely; the limit is 0 before a fit.
  UsualLevel noise_;
  bool noise_of_change_ = false;
  UsualLevel outside_;              ///< V^2, as a function of the change's square
  PrincipalDirections directions_;  ///< of the shapes
  double least_size_ = 0;           ///< square of what is added to a change's size, V^2
  double largest_ = 0;              ///< square of a change's size, V^2
  double farthest_ = 0;             ///< square of the Mahalanobis distance
  double lowest_ = 0;               ///< shape along the tilt
  double highest_ = 0;
  std::shared_ptr<const FrameCheck> flagging_;  ///< fitted to usual frames; null: this one
};

}  // namespace ertbench
