#include "bench/contacts/true_contacts.h"

namespace ertbench {

std::vector<Eigen::Vector2d> true_places_mm(const Sensor& sensor, const Scene& scene) {
  std::vector<Eigen::Vector2d> places;
  for (const Contact& contact : scene.contacts) {
    const Eigen::Vector2d place = contact.centroid();
    if (sensor.sheet->depth(place) >= 0) places.emplace_back(place * sensor.sheet->unit_mm());
  }
  return places;
}

std::vector<Eigen::Vector2d> places_mm(const Sensor& sensor, std::span<const FoundContact> found) {
  std::vector<Eigen::Vector2d> places;
  for (const FoundContact& contact : found) {
    places.emplace_back(contact.place * sensor.sheet->unit_mm());
  }
  return places;
}

}  // namespace ertbench
