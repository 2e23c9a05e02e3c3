#pragma once

namespace ertbench {

/// What counts as a contact in an image of changes of the conductivity, δσ.
struct ContactRule {
  /// Of the image's largest |δσ| (D.1): pixels with less belong to no contact.
  double threshold = 0.25;
  /// The least |δσ| over the background that counts at all; an image without it shows no contact.
  double floor = 0;
  /// Two maxima are two contacts where the way between them goes lower than this part of the lower
  /// one; else they are one.
  double saddle = 0.7;
  int least_pixels = 1;  ///< of a contact

  bool operator==(const ContactRule&) const = default;
};

}  // namespace ertbench
