#include "bench/score/metric_formulas.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/score/assignment.h"
#include "forward/data/sheet_model.h"

namespace ertbench {
namespace {

using Eigen::ArrayXXd;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;

/// Centre of gravity of a polygon; no value for a polygon without area.
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

/// A contact that touches the border from within counts as inside.
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

/// `values` weighted by the share of each pixel's area on the sheet to the power `power`: 1 for
/// sums, 1/2 for norms. Unchanged if the sheet fills its image.
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

constexpr int kReach = 5;  ///< pixels from the middle of a window to its edge
constexpr double kDeviation = 1.5;

/// [n, n]: row i holds the weights of the window around pixel i of a line of n pixels, a Gaussian
/// cut at the ends of the line, with sum 1. The window of an image is the product of two of these.
MatrixXd window_weights(int n) {
  MatrixXd weights = MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = std::max(0, i - kReach); j <= std::min(n - 1, i + kReach); ++j) {
      const double distance = (j - i) / kDeviation;
      weights(i, j) = std::exp(-distance * distance / 2);
    }
    weights.row(i) /= weights.row(i).sum();
  }
  return weights;
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

std::optional<double> detected_contacts(const ScoredImage& image) { return image.contacts.matched; }

std::optional<double> false_positives(const ScoredImage& image) {
  return image.contacts.found - image.contacts.matched;
}

std::optional<double> ratio_or_none(double part, double whole) {
  return whole == 0 ? std::nullopt : std::optional(part / whole);
}

std::optional<double> precision_of_contacts(const ScoredImage& image) {
  return ratio_or_none(image.contacts.matched, image.contacts.found);
}

std::optional<double> recall_of_contacts(const ScoredImage& image) {
  return ratio_or_none(image.contacts.matched, image.contacts.true_count);
}

std::optional<double> location_error(const ScoredImage& image) {
  return ratio_or_none(image.contacts.distance_mm, image.contacts.matched);
}

std::optional<double> count_error(const ScoredImage& image) {
  return std::abs(image.contacts.found - image.contacts.true_count);
}

std::optional<double> ospa_distance(const ScoredImage& image) { return image.contacts.ospa_mm; }

ContactScore score_places(std::span<const Vector2d> true_mm, std::span<const Vector2d> found_mm,
                          const ContactDistances& distances) {
  ContactScore out;
  out.true_count = static_cast<int>(true_mm.size());
  out.found = static_cast<int>(found_mm.size());
  const Eigen::MatrixXd apart = distances_between(true_mm, found_mm);
  for (const auto& [row, column] : assign(apart, distances.match).pairs) {
    ++out.matched;
    out.distance_mm += apart(row, column);
  }
  out.ospa_mm = ospa(true_mm, found_mm, distances.ospa);
  return out;
}

ContactScore score_contacts(const Sensor& sensor, const ContactDistances& distances,
                            const Scene& scene, std::span<const FoundContact> found) {
  return score_places(true_places_mm(sensor, scene), places_mm(sensor, found), distances);
}

std::optional<double> structural_similarity(const ScoredImage& image) {
  if (image.truth_is_empty()) return std::nullopt;
  const PixelGrid pixels = image.sensor.image();
  const double range =
      std::max(image.true_change.maxCoeff(), 0.0) - std::min(image.true_change.minCoeff(), 0.0);
  const double c1 = 0.01 * 0.01;
  const double c2 = 0.03 * 0.03;
  // Both in units of the dynamic range, which is 1 from here on.
  const ArrayXXd x =
      Eigen::Map<const ArrayXXd>(image.change.data(), pixels.columns(), pixels.rows()) / range;
  const ArrayXXd y =
      Eigen::Map<const ArrayXXd>(image.true_change.data(), pixels.columns(), pixels.rows()) / range;

  // Column-major: a pixel's column is the first index.
  const MatrixXd across = window_weights(pixels.columns());
  const MatrixXd along = window_weights(pixels.rows());
  const auto averaged = [&](const ArrayXXd& values) -> ArrayXXd {
    return (across * values.matrix() * along.transpose()).array();
  };
  const ArrayXXd mean_x = averaged(x);
  const ArrayXXd mean_y = averaged(y);
  const ArrayXXd variances = averaged(x.square() + y.square()) - mean_x.square() - mean_y.square();
  const ArrayXXd covariance = averaged(x * y) - mean_x * mean_y;
  const ArrayXXd similarity = (2 * mean_x * mean_y + c1) * (2 * covariance + c2) /
                              ((mean_x.square() + mean_y.square() + c1) * (variances + c2));
  if (pixels.all_on_sheet()) return similarity.mean();
  double sum = 0;
  for (int p = 0; p < pixels.count(); ++p) {
    if (pixels.on_sheet(p)) sum += similarity.data()[p];
  }
  return sum / pixels.count_on_sheet();
}

ExplainedChange::ExplainedChange(const Sensor& sensor, const Eigen::VectorXd& reference)
    : jacobian_(uniform_jacobian(sensor)), reference_(reference) {}

std::optional<double> ExplainedChange::of(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                          const Eigen::Ref<const Eigen::RowVectorXd>& image) const {
  const double size = change.norm();
  if (!(size > 0)) return std::nullopt;
  Eigen::MatrixXd responses(change.size(), 2);
  responses.col(0) = jacobian_ * image.transpose();
  responses.col(1) = reference_;
  // The first column is zero for an empty image; the rank-revealing decomposition drops it.
  const auto decomposed = responses.completeOrthogonalDecomposition();
  const Eigen::VectorXd best = decomposed.solve(change.transpose());
  const double left = (change.transpose() - responses * best).norm();
  return std::clamp(1 - left / size, 0.0, 1.0);
}

}  // namespace ertbench
