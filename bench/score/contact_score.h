#pragma once

#include <span>

#include "bench/contacts/contact_settings.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// The contacts found in one frame, held against those of its scene.
///
/// A true contact is one whose centroid lies on the sheet. Found and true ones are matched by
/// `assign` with the cut-off ContactDistances::match.
struct ContactScore {
  int there = 0;           ///< true contacts
  int found = 0;           ///< found contacts, right ones and ghosts
  int matched = 0;         ///< pairs of the two
  double distance_mm = 0;  ///< sum over the pairs
  double ospa_mm = 0;      ///< of both sets, with the cut-off ContactDistances::ospa
};

ContactScore score_contacts(const Sensor& sensor, const ContactDistances& distances,
                            const Scene& scene, std::span<const FoundContact> found);

}  // namespace ertbench
