#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "core/json_reader.h"
#include "forward/border/elliptic_contact.h"

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

}  // namespace ertbench
