#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/json.h"
#include "forward/border/contact_electrodes.h"
#include "forward/sheet/sensor.h"
#include "solvers/nuisances.h"

namespace ertbench {

class DatasetFile;

/// Prior distribution of a contact: the position is uniform on the sheet; size, stretch and ratio
/// are independent Gaussians. The logarithm of the conductivity ratio is Gaussian about plus or
/// minus its mean, as a contact conducts better or worse than the background and seldom the same.
struct ContactPrior {
  double log_size_mean = -1.6;  ///< 0.2 domain units
  double log_size_deviation = 0.6;
  double stretch_deviation = 0.2;  ///< of either component
  double log_ratio_mean = 0.7;     ///< of the absolute value
  double log_ratio_deviation = 0.7;
  bool may_fall = true;  ///< contacts may conduct worse than the background
  bool may_rise = true;  ///< contacts may conduct better than the background

  /// Distribution of the contacts in a training set, each taken as the ellipse of its area and
  /// second moments. Throws InputError if the set has no contact.
  static ContactPrior of(const DatasetFile& training);

  /// Adds gradient and curvature of -log density with respect to the contact's parameters to
  /// `gradient` and `curvature`; `weight` multiplies the inverse variances. Returns -log density
  /// without its constant.
  double add_to(const EllipticContact& contact, double weight,
                Eigen::Ref<EllipticContact::Vector> gradient,
                Eigen::Ref<EllipticContact::Vector> curvature) const;
  /// Logarithm of the density's constant, of an ellipse; `sheet_area` in squared domain units.
  double log_constant(double weight, double sheet_area) const;
};

nlohmann::json to_json(const ContactPrior& prior);
ContactPrior contact_prior_from_json(JsonObject object);

/// W [pairs, pairs], 1/V, with W C W' = 1 and C = noise^2 / 2 + N N' / 2 for the means of
/// reciprocal pairs; N are the nuisances' columns, `noise` that of a channel, V. (The common factor
/// of gain and level is estimated and removed from the frame until it acts linearly, see
/// ContactSolver.)
Eigen::MatrixXd whitening_of(const Sensor& sensor, double noise, const Nuisances& nuisances);

}  // namespace ertbench
