#pragma once

#include "forward/border/elliptic_contact.h"

namespace ertbench {

/// The ellipse of a contact's area, centroid and second moments, up to the size that these give a
/// shape that is no ellipse, and of its conductivity: an ellipse itself, a square's disc.
EllipticContact nearest_ellipse(const Contact& contact);

}  // namespace ertbench
