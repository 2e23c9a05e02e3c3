#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "core/json.h"
#include "forward/border/contact_electrodes.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

class DatasetFile;

/// What is known of a contact before a frame is seen: its place is anywhere on the sheet alike, and
/// its size, stretch and ratio are independent Gaussians. The logarithm of the ratio is Gaussian
/// about plus or minus its mean, whichever sign it has: a contact conducts better or worse, and
/// seldom the same.
struct ContactPrior {
  double log_size_mean = -1.6;  ///< of a contact of 0.2 domain units
  double log_size_deviation = 0.6;
  double stretch_deviation = 0.2;  ///< of either component
  double log_ratio_mean = 0.7;     ///< of its amount
  double log_ratio_deviation = 0.7;
  bool may_fall = true;  ///< whether contacts conduct worse than the background
  bool may_rise = true;  ///< or better

  /// That of the contacts in a training set: of each the ellipse of the same area and second
  /// moments. Throws InputError where the set holds no contact.
  static ContactPrior of(const DatasetFile& training);

  /// Gradient of -log density by the contact's parameters, added to `gradient`, and its curvature,
  /// added to `curvature`; `weight` multiplies the inverse variances. Returns -log density less its
  /// constant.
  double add_to(const EllipticContact& contact, double weight,
                Eigen::Ref<EllipticContact::Vector> gradient,
                Eigen::Ref<EllipticContact::Vector> curvature) const;
  /// Log of the density's constant: over a sheet of so many squared domain units, of an ellipse or
  /// of a disc.
  double log_constant(double weight, double sheet_area, bool ellipse) const;
};

nlohmann::json to_json(const ContactPrior& prior);
ContactPrior contact_prior_from_json(JsonObject object);

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
