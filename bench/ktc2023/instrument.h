#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bench/ktc2023/tank_model.h"

namespace ertbench {

/// How a file of KTC2023 was measured. A channel is a drive and a measuring pair, drive by drive.
struct KtcPatterns {
  Eigen::MatrixXd currents;      ///< [32, drives] mA, "Inj"
  Eigen::MatrixXd measurements;  ///< [32, measurements], "Mpat", 1 and -1

  Eigen::Index channels() const { return currents.cols() * measurements.cols(); }
  Eigen::Index drive_of(Eigen::Index channel) const { return channel / measurements.cols(); }
  /// Current of a channel's drive, mA.
  double amplitude(Eigen::Index channel) const;
  /// Whether a channel drives or measures at one of the first `electrodes`.
  bool uses_first(Eigen::Index channel, int electrodes) const;
};

/// What the empty tank says of the instrument: the complete electrode model's conductivity and
/// contact impedances, and how the amplifier of each measuring pair departs from an ideal one.
struct KtcCalibration {
  double conductivity = 0.75;  ///< S
  Eigen::VectorXd contact_impedance = Eigen::VectorXd::Constant(TankModel::electrodes, 1e-5);
  Eigen::VectorXd gain;         ///< [measurements], 0 for an ideal one
  Eigen::VectorXd common_mode;  ///< [measurements], part of the pair's mean potential over the sink
  /// Norm of what is left of the reference over the reference's: with conductivity alone, then also
  /// with impedances, common mode and gains.
  std::vector<double> unexplained;
  /// Between drives that are measured twice, and between those that are measured in both
  /// directions: norm of the difference over sqrt(2), over the voltages'.
  double repeated = 0;
  double reversed = 0;
  TankModel::Solution empty;  ///< the model's
};

/// Voltages per mA of a channel by packed resistances, [channels, 528]: u of its pair times 1 +
/// gain, and its common mode, the mean potential of the pair over that of the electrode where the
/// current leaves.
Eigen::MatrixXd channel_operator(const KtcPatterns& patterns, const Eigen::VectorXd& gain,
                                 const Eigen::VectorXd& common_mode);

/// How far a calibration goes, each step on top of those before.
inline const std::vector<std::string> ktc_calibration_steps = {"conductivity", "impedances",
                                                               "common-mode", "all"};

/// Fits the model to the empty tank's `voltages` [channels]; those that are NaN are left out.
/// Nothing else is looked at. `step` is the last one.
KtcCalibration calibrate_ktc(const TankModel& tank, const KtcPatterns& patterns,
                             const Eigen::VectorXd& voltages, const std::string& step = "all");

}  // namespace ertbench
