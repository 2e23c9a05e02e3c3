#include "bench/score/metric_formulas.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "bench/contacts/image_moments.h"
#include "bench/score/contact_score.h"
#include "bench/score/scored_image.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;

/// Centre of gravity of a polygon's area; none where it has no area.
std::optional<Vector2d> area_centroid(const std::vector<Vector2d>& vertices) {
  double twice_area = 0;
  Vector2d moment = Vector2d::Zero();
  const Vector2d origin = vertices.empty() ? Vector2d::Zero() : vertices.front();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vector2d a = vertices[i] - origin;
    const Vector2d b = vertices[(i + 1) % vertices.size()] - origin;
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  if (std::abs(twice_area) <= 1e-12) return std::nullopt;
  return Vector2d(origin + moment / (3 * twice_area));
}

/// Touching the border counts as within.
bool lies_within(const Contact& contact, const Sheet& sheet) {
  constexpr double rounding = 1e-12;
  if (sheet.encloses(contact.bounds(), -rounding)) return true;
  return contact.shape == Shape::disc &&
         sheet.depth(contact.centre) >= contact.half_size.x() - rounding;
}

std::optional<double> distance(const std::optional<Vector2d>& a, const std::optional<Vector2d>& b) {
  if (!a || !b) return std::nullopt;
  return (*a - *b).norm();
}

/// Distance of the centroid of `weights` from the true centre.
std::optional<double> position_error_of(const ScoredImage& image, const RowVectorXd& weights) {
  if (image.truth_is_empty() || image.is_empty()) return std::nullopt;
  return distance(centroid(image.sensor, weights),
                  true_centre(image.sensor, image.scene, image.true_change));
}

/// What of an image is on the sheet: pixels times the part of their area that is, to the power of
/// `power`: 1 for sums, 1/2 for norms. As it is where the sheet fills its image.
RowVectorXd on_sheet(const Sensor& sensor, const RowVectorXd& values, double power) {
  if (sensor.sheet->fills_bounds()) return values;
  const PixelGrid pixels = sensor.image();
  RowVectorXd out = values;
  for (int p = 0; p < pixels.count(); ++p) out[p] *= std::pow(pixels.part_on_sheet(p), power);
  return out;
}

double norm_on_sheet(const Sensor& sensor, const RowVectorXd& values) {
  return on_sheet(sensor, values, 0.5).norm();
}

}  // namespace

std::optional<Vector2d> true_centre(const Sensor& sensor, const Scene& scene,
                                    const RowVectorXd& true_change) {
  if (scene.contacts.size() == 1) {
    const Contact& contact = scene.contacts.front();
    if (lies_within(contact, *sensor.sheet)) {
      std::optional<Vector2d> centre = contact.shape == Shape::polygon
                                           ? area_centroid(contact.vertices)
                                           : std::optional(contact.centre);
      if (centre) return centre;
    }
  }
  return centroid(sensor, true_change);
}

bool ScoredImage::truth_is_empty() const { return ertbench::is_empty(sensor, true_change); }
bool ScoredImage::is_empty() const { return ertbench::is_empty(sensor, change); }

std::optional<double> resolution_of(const Sensor& sensor, const RowVectorXd& change) {
  if (is_empty(sensor, change)) return std::nullopt;
  // Areas in pixels. The largest pixel always counts, so the root's argument is never negative.
  const auto bright = (thresholded(change, 0.5).array() != 0).count();
  const auto total = static_cast<double>(sensor.image().count_on_sheet());
  return (1 - std::sqrt(static_cast<double>(bright - 1) / total)) * 100;
}

std::optional<double> amplitude_response(const ScoredImage& image) {
  if (image.truth_is_empty() || cancels(image.true_change)) return std::nullopt;
  return on_sheet(image.sensor, image.change, 1).sum() /
         on_sheet(image.sensor, image.true_change, 1).sum();
}

std::optional<double> image_resolution(const ScoredImage& image) {
  return resolution_of(image.sensor, image.change);
}

std::optional<double> resolution_error(const ScoredImage& image) {
  const auto seen = resolution_of(image.sensor, image.change);
  const auto ideal = resolution_of(image.sensor, image.true_change);
  if (!seen || !ideal) return std::nullopt;
  return std::abs(*seen - *ideal);
}

std::optional<double> position_error(const ScoredImage& image) {
  return position_error_of(image, image.change);
}

std::optional<double> position_error_of_the_peak(const ScoredImage& image) {
  return position_error_of(image, thresholded(image.change, 0.25));
}

std::optional<double> relative_image_error(const ScoredImage& image) {
  return norm_on_sheet(image.sensor, image.change - image.true_change) /
         norm_on_sheet(image.sensor, image.conductivity);
}

std::optional<double> relative_error_of_change(const ScoredImage& image) {
  if (image.truth_is_empty()) return std::nullopt;
  return norm_on_sheet(image.sensor, image.change - image.true_change) /
         norm_on_sheet(image.sensor, image.true_change);
}

std::optional<double> correlation_coefficient(const ScoredImage& image) {
  const auto centred = [&](const RowVectorXd& values) -> RowVectorXd {
    const int count = image.sensor.sheet->fills_bounds() ? static_cast<int>(values.size())
                                                         : image.sensor.image().count_on_sheet();
    return on_sheet(image.sensor, values.array() - values.sum() / count, 0.5);
  };
  const RowVectorXd seen = centred(image.change);
  const RowVectorXd ideal = centred(image.true_change);
  if (is_empty(image.sensor, seen) || is_empty(image.sensor, ideal)) return std::nullopt;
  return seen.dot(ideal) / (seen.norm() * ideal.norm());
}

std::optional<double> contacts_found(const ScoredImage& image) { return image.contacts.matched; }

std::optional<double> ghosts(const ScoredImage& image) {
  return image.contacts.found - image.contacts.matched;
}

std::optional<double> precision_of_contacts(const ScoredImage& image) {
  const ContactScore& contacts = image.contacts;
  if (contacts.found == 0) return std::nullopt;
  return static_cast<double>(contacts.matched) / contacts.found;
}

std::optional<double> recall_of_contacts(const ScoredImage& image) {
  const ContactScore& contacts = image.contacts;
  if (contacts.there == 0) return std::nullopt;
  return static_cast<double>(contacts.matched) / contacts.there;
}

std::optional<double> location_error(const ScoredImage& image) {
  const ContactScore& contacts = image.contacts;
  if (contacts.matched == 0) return std::nullopt;
  return contacts.distance_mm / contacts.matched;
}

std::optional<double> count_error(const ScoredImage& image) {
  return std::abs(image.contacts.found - image.contacts.there);
}

std::optional<double> ospa_distance(const ScoredImage& image) { return image.contacts.ospa_mm; }

}  // namespace ertbench
