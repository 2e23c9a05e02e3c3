#pragma once

#include <Eigen/Core>

#include "forward/sheet/sensor.h"
#include "solvers/front/frame_check.h"
#include "solvers/nuisances.h"
#include "solvers/solver.h"

namespace ertbench {

/// A solver that can be told what is wrong with a frame.
class ToldSolver {
 public:
  virtual ~ToldSolver() = default;
  /// If true, frames come with the channels of dead electrodes imputed (FrameCheck::impute), and
  /// FrameReport::dead names these electrodes. Valid after `fit` or `load`.
  virtual bool is_told() const = 0;
  /// Frames that are usual to the solver, which the frame check does not flag: those of
  /// the input with the faults of its training, [frames, channels] V, changes; none if there are
  /// none. Valid after `fit` or `load`.
  virtual Frames usual_frames(const FitInput&) const { return {}; }
};

/// What is wrong with a frame, known before its image.
struct FrameState {
  /// Per nuisance: level (relative change of the conductivity), gradient in x and in y (relative
  /// per domain unit), displacement of each electrode (domain units), as far as the front has them.
  using Amplitudes = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 67, 1>;

  ElectrodeSet dead = 0;       ///< read zero, float, are loose or half dead
  ElectrodeSet floating = 0;   ///< of the dead ones: float or are loose
  ElectrodeSet half_dead = 0;  ///< of the dead ones: all channels read a share too little
  double lost = 0;             ///< that share
  bool saturated = false;      ///< channels stand at the end of the converter's range
  double noise = 0;            ///< standard deviation of a channel, V
  /// Square of what neither the directions of scenes nor the nuisances explain, relative to what is
  /// usual at the frame's size and noise.
  double unexplained = 0;
  Amplitudes amplitudes;  ///< posterior means; empty without a fit
  Amplitudes deviations;  ///< posterior standard deviations
};

/// Finds out what is wrong with a frame, for any solver that stands behind it. Level and gradient
/// take 3 us a frame, displaced electrodes besides as much again.
///
/// A sound frame d' is a scene, nuisances and noise: with the size |d'| and the moments of shapes
/// of a FrameCheck it is Gaussian of covariance
///
///     C = |d'|^2 (mean mean^T + B B^T) + N N^T + rho 1,
///
/// N the responses of the nuisances times their deviations, rho the noise and what no direction
/// explains. In the eigenvectors of the shapes' moments all but N is diagonal, so that a frame
/// costs one product and a small system for the amplitudes of the nuisances.
class Front {
 public:
  /// `nuisances`: prior deviations of the amplitudes.
  explicit Front(const Sensor& sensor, const Nuisances& nuisances = {});
  Front(const Sensor& sensor, FrameCheck check, const Nuisances& nuisances = {});

  /// Judges one frame [channels], contiguous: V, change from the reference.
  FrameState look(const double* change) const;
  /// Takes level and gradient out of a frame, as far as the front has them.
  void remove_nuisances(const FrameState& state, double* change) const;

  /// What is told of a frame as numbers beside its channels: for each electrode 1 if it is dead and
  /// 0 otherwise, then the frame's noise, (SNR in dB - 50) / 15.
  static int told(const Sensor& sensor) { return sensor.electrode_count + 1; }
  /// Writes what is told of a frame whose dead electrodes are known.
  void tell(const double* change, ElectrodeSet dead, float* told) const;
  /// Finds the dead electrodes, imputes their channels and tells.
  void prepare(double* change, float* told) const;

 private:
  static constexpr int most = 67;  ///< amplitudes: 3 and one for each of 64 electrodes
  using Scores = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 40, 1>;

  /// Standard deviation of a channel's noise from the reciprocal pairs without the `dead`
  /// electrodes, V; 0 if there are none.
  double noise(const double* change, ElectrodeSet dead) const;
  bool saturated(const double* change) const;
  void set_model(const Sensor& sensor, const Nuisances& nuisances);

  FrameCheck check_;
  int electrodes_ = 0;
  Eigen::ArrayXd reference_;    ///< [channels] V
  double reference_size_ = 0;   ///< root mean square of the reference voltages, V
  FrameCheck::Shapes shapes_;   ///< of the check; empty without a fit
  Eigen::VectorXd moments_;     ///< eigenvalues of the shapes' second moments
  Eigen::MatrixXd responses_;   ///< [channels, level and gradients], of size one
  Eigen::VectorXd deviations_;  ///< [nuisances]
  Eigen::Index nuisances_ = 0;
  RowMajorMatrix rows_;     ///< [eigenvectors and nuisances, pairs]
  Eigen::MatrixXd within_;  ///< [eigenvectors, nuisances]
  Eigen::MatrixXd beside_;  ///< [nuisances, nuisances], products outside of the eigenvectors
};

}  // namespace ertbench
