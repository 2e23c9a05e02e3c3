#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/json_reader.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What may be wrong in every frame beside its noise, each with a standard deviation: unknowns that
/// a fit carries along. Their effect on the voltages is taken as linear, so that integrating over
/// them is no more than another covariance of the noise,
///
///     C = noise^2 / 2 + sum n n' deviation^2  over the columns n of derivatives.
struct Nuisances {
  double gain = 0;        ///< of all voltages, relative: current, amplifiers, the whole background
  double gradient = 0;    ///< of the background across the sheet, relative per domain unit, x and y
  double electrodes = 0;  ///< place of each electrode along the border, domain units

  bool any() const { return gain > 0 || gradient > 0 || electrodes > 0; }

  /// The optional `"nuisances": {"gain", "gradient", "electrodes"}`, numbers > 0.
  static Nuisances from_json(JsonObject& parameters);
  void add_to(nlohmann::json& parameters) const;
};

/// W with W C W' = 1, for the means of reciprocal pairs, [pairs, pairs] per V: `noise` V is that of
/// a channel.
Eigen::MatrixXd whitening_of(const Sensor& sensor, double noise, const Nuisances& nuisances);

}  // namespace ertbench
