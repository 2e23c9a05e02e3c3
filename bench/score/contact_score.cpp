#include "bench/score/contact_score.h"

#include "bench/contacts/assignment.h"
#include "bench/contacts/ospa.h"
#include "bench/contacts/true_contacts.h"

namespace ertbench {

ContactScore score_contacts(const Sensor& sensor, const ContactDistances& distances,
                            const Scene& scene, std::span<const FoundContact> found) {
  const std::vector<Eigen::Vector2d> there = true_places_mm(sensor, scene);
  const std::vector<Eigen::Vector2d> seen = places_mm(sensor, found);
  ContactScore out;
  out.there = static_cast<int>(there.size());
  out.found = static_cast<int>(seen.size());
  const Eigen::MatrixXd apart = distances_between(there, seen);
  for (const auto& [row, column] : assign(apart, distances.match).pairs) {
    ++out.matched;
    out.distance_mm += apart(row, column);
  }
  out.ospa_mm = ospa(there, seen, distances.ospa);
  return out;
}

}  // namespace ertbench
