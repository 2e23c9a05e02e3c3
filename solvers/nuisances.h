#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/json.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// Nuisance parameters of every frame, as standard deviations. Their effect on the voltages is
/// taken as linear, so that integrating over them only adds N N^T to the covariance of the noise
/// (Soleimani, Gomez-Laberge and Adler, Physiol. Meas. 27, 2006, for the electrodes).
struct Nuisances {
  double gain = 0;  ///< common relative gain of current and amplifiers
  /// Relative change of the whole sheet's conductivity, such as from water around it. It acts on
  /// the voltages as a gain of 1 / (1 + level) and can be separated from one only by the priors.
  double level = 0;
  double gradient = 0;    ///< of the background in x and in y, relative per domain unit
  double electrodes = 0;  ///< displacement of each electrode along the border, domain units

  /// Deviation of the factor common to all voltages.
  double factor() const { return std::hypot(gain, level); }
  bool any() const { return factor() > 0 || gradient > 0 || electrodes > 0; }
  /// [channels, columns] V: derivatives of the untouched sheet's voltages times deviations, for the
  /// factor, the gradient in x and in y and each electrode, as far as they are above zero.
  Eigen::MatrixXd responses(const Sensor& sensor) const;
  /// N [pairs, columns] V: d' (Reciprocity) of the responses.
  Eigen::MatrixXd columns(const Sensor& sensor) const;

  /// The optional `"nuisances": {"gain", "level", "gradient", "electrodes"}`, numbers > 0.
  static Nuisances from_json(JsonObject& parameters, const std::string& key = "nuisances");
  static ParameterInfo parameter();
  void add_to(nlohmann::json& parameters, const std::string& key = "nuisances") const;
};

}  // namespace ertbench
