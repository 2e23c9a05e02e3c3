#include "bench/contacts/frame_reading.h"

#include "bench/contacts/image_moments.h"

namespace ertbench {
namespace {

std::optional<Eigen::Vector2d> centroid_mm(const Sensor& sensor,
                                           const Eigen::Ref<const Eigen::RowVectorXd>& change) {
  if (is_empty(sensor, change)) return std::nullopt;
  std::optional<Eigen::Vector2d> place = centroid(sensor, change);
  if (place) *place *= sensor.sheet->unit_mm();
  return place;
}

}  // namespace

FrameReading frame_reading(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           std::span<const FoundContact> contacts) {
  const double mm = sensor.sheet->unit_mm();
  FrameReading out;
  for (const FoundContact& contact : contacts) {
    out.contacts.push_back(
        {contact.place * mm, contact.strength * mm * mm, contact.peak, contact.area * mm * mm});
  }
  Eigen::Index highest = 0;
  change.cwiseAbs().maxCoeff(&highest);
  out.peak = change[highest];
  out.sum = change.sum() * sensor.image().pixel_area() * mm * mm;
  out.centroid_mm = centroid_mm(sensor, change);
  out.centroid25_mm = centroid_mm(sensor, thresholded(change, 0.25));
  return out;
}

}  // namespace ertbench
