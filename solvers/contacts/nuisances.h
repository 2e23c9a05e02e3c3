#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json_fwd.hpp>

#include "core/json_reader.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What may be wrong in every frame beside its noise, each with a standard deviation: unknowns that
/// a fit carries along. Their effect on the voltages is taken as linear, so that integrating over
/// them is no more than another covariance of the noise (the factor of gain and level is estimated
/// and taken out of the frame until it is linear: ContactSolver),
///
///     C = noise^2 / 2 + sum n n' deviation^2  over the columns n of derivatives.
struct Nuisances {
  double gain = 0;  ///< of all voltages, relative: current, amplifiers
  /// Relative change of the whole sheet's conductivity, as when water around it rises. To the
  /// voltages it is a gain of 1 / (1 + level), and is told from one by what is expected alone.
  double level = 0;
  double gradient = 0;    ///< of the background across the sheet, relative per domain unit, x and y
  double electrodes = 0;  ///< place of each electrode along the border, domain units

  /// Of the factor that all voltages have in common.
  double factor() const { return std::hypot(gain, level); }
  bool any() const { return factor() > 0 || gradient > 0 || electrodes > 0; }

  /// The optional `"nuisances": {"gain", "level", "gradient", "electrodes"}`, numbers > 0.
  static Nuisances from_json(JsonObject& parameters);
  void add_to(nlohmann::json& parameters) const;
};

/// W with W C W' = 1, for the means of reciprocal pairs, [pairs, pairs] per V: `noise` V is that of
/// a channel.
Eigen::MatrixXd whitening_of(const Sensor& sensor, double noise, const Nuisances& nuisances);

}  // namespace ertbench
