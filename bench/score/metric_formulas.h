#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "bench/score/image_contacts.h"
#include "core/arrays.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Detections of one frame matched with the contacts of its scene.
///
/// A true contact is one whose centroid lies on the sheet. Detections and true contacts are matched
/// one to one by `assign` with the cut-off ContactDistances::match.
struct ContactScore {
  int true_count = 0;      ///< true contacts
  int found = 0;           ///< detections, true and false positives
  int matched = 0;         ///< pairs of a true contact and a detection
  double distance_mm = 0;  ///< sum over the pairs
  double ospa_mm = 0;      ///< between both sets, with the cut-off ContactDistances::ospa
};

/// One image and its truth, the input of every metric's formula. All pixels are finite.
struct ScoredImage {
  const Sensor& sensor;
  const Scene& scene;
  const Eigen::RowVectorXd& conductivity;  ///< [pixels] S/m, true
  const Eigen::RowVectorXd& true_change;   ///< [pixels] S/m
  const Eigen::RowVectorXd& change;        ///< [pixels] S/m, estimated
  const ContactScore& contacts;            ///< set for metrics of contacts only

  bool truth_is_empty() const;
  bool is_empty() const;
};

/// The true centre, domain units: the contact's where the scene has exactly one and it lies wholly
/// on the sheet, else the centroid of the true change (C4). No value if that centroid is undefined.
std::optional<Eigen::Vector2d> true_centre(const Sensor& sensor, const Scene& scene,
                                           const Eigen::RowVectorXd& true_change);

/// RES (C2) of one image of changes, %; undefined for an empty image.
std::optional<double> resolution_of(const Sensor& sensor, const Eigen::RowVectorXd& change);

// The formulas of the metrics. dσ is the true change of the conductivity, dσ^ the estimated one;
// C1 ... C5 and D.1 are numbers in the supplement of the DD-ERT paper (Zheng et al.).
//
// An image is empty if no |dσ| is above 1e-9 of the background. An undefined metric has no value.
// Images with pixels that are not finite reach no formula.

using MetricFormula = std::optional<double>(const ScoredImage&);

/// sum(dσ^) / sum(dσ) (C1). Undefined if the truth is empty or its sum cancels: |sum| <= 1e-3
/// sum|.|.
MetricFormula amplitude_response;

/// (1 - sqrt((A50 - A_pixel) / A_total)) 100 of the image (C2), %. Undefined for an empty image.
MetricFormula image_resolution;

/// |RES - RES of the truth|, %. Undefined if either image is empty.
MetricFormula resolution_error;

/// Distance of the centroid of dσ^ from true_centre (C3, C4), domain units. Undefined if either
/// image is empty or its weights cancel, |sum| <= 1e-3 sum|.|: positive and negative parts are then
/// equal to a thousandth, and the centroid, amplified 1000 times, may lie anywhere.
MetricFormula position_error;

/// Position error after pixels below 25 % of the largest |dσ^| are set to zero (D.1).
MetricFormula position_error_of_the_peak;

/// ||σ^ - σ|| / ||σ||, absolute conductivities (C5).
MetricFormula relative_image_error;

/// ||dσ^ - dσ|| / ||dσ||; the empty image scores 1. Undefined if the truth is empty.
MetricFormula relative_error_of_change;

/// Structural similarity of dσ^ and dσ (Wang, Bovik, Sheikh and Simoncelli 2004), the mean over all
/// pixels of
///
///     (2 μ μ^ + C1) (2 cov + C2) / ((μ² + μ^² + C1) (var + var^ + C2))
///
/// with the mean values, variances and covariance of a window around the pixel: 11 x 11 pixels,
/// weighted by a Gaussian of standard deviation 1.5 pixels whose weights sum up to 1, and C1 =
/// (.01 L)², C2 = (.03 L)². Windows are cut at the border of the sheet and their weights normalised
/// again: only 14 x 14 of 24 x 24 pixels have a whole window, and contacts near the border would
/// not count. The dynamic range L is the span of the true change including 0, max(dσ, 0) -
/// min(dσ, 0), so that the result depends neither on the unit nor on the strength of the contact.
/// Undefined if the truth is empty.
MetricFormula structural_similarity;

/// Pearson's correlation coefficient of dσ^ and dσ over the pixels. Undefined if one of the two is
/// constant: no pixel further from the mean than 1e-9 of the background.
MetricFormula correlation_coefficient;

/// part / whole; no value if `whole` is 0.
std::optional<double> ratio_or_none(double part, double whole);

// Metrics of the contacts detected in the frame; ContactScore defines the terms.

/// Number of true contacts that are matched with a detection.
MetricFormula detected_contacts;

/// Number of detections that are matched with no true contact.
MetricFormula false_positives;

/// Matched pairs over detections. Undefined without a detection.
MetricFormula precision_of_contacts;

/// Matched pairs over true contacts. Undefined without a true contact.
MetricFormula recall_of_contacts;

/// Mean distance of matched pairs, mm. Undefined without a pair.
MetricFormula location_error;

/// |detections - true contacts|.
MetricFormula count_error;

/// OSPA distance of order 1 between detections and true contacts (Schuhmacher, Vo and Vo 2008), mm.
MetricFormula ospa_distance;

/// Matches and counts the contacts detected in one frame, mm.
ContactScore score_places(std::span<const Eigen::Vector2d> true_mm,
                          std::span<const Eigen::Vector2d> found_mm,
                          const ContactDistances& distances);
/// The same for a scene and the detections in it, `found` in domain units.
ContactScore score_contacts(const Sensor& sensor, const ContactDistances& distances,
                            const Scene& scene, std::span<const FoundContact> found);

// Columns of the table of metrics (metric_entries.h).

/// Metrics of one image, in the order of the table.
enum class Metric {
  AR,
  RES,
  RES_error,
  PE,
  PE25,
  RIE,
  relative_error,
  SSIM,
  CC,
  detected,
  false_positives,
  precision,
  recall,
  location_error_mm,
  count_error,
  ospa_mm
};

/// Kind of a metric's values; it decides how they scale with the sheet.
enum class Quantity {
  ratio,        ///< dimensionless, of the order of 1
  percent,      ///< dimensionless, in %
  length,       ///< domain units, in which the sheet is 2 x 2
  millimetres,  ///< a length on the sheet
  number,       ///< a count
};

/// Which of two values is better.
enum class Better {
  smaller,  ///< an error: the ideal is 0 and the least possible value
  larger,   ///< the ideal is the largest possible value
  nearer,   ///< the one nearer to the ideal, which may be missed on either side
};

/// Score of a perfect image.
struct Ideal {
  double value = 0;
  /// The ideal is the score of the true images; `value` stands in if those were not scored.
  bool of_truth = false;
};

/// How the value of one frame jumps when a pixel crosses a threshold.
enum class Threshold {
  none,      ///< no pixel is compared with a threshold
  area,      ///< counts the pixels above the threshold (C2)
  centroid,  ///< a position to which only pixels above the threshold contribute (D.1)
  contact,   ///< counts or locates contacts; one pixel may create or remove a contact
};

/// A row of the table of metrics, which says what is not usual of one.
struct MetricEntry {
  Metric metric;
  const char* name;  ///< in files: summary.json, experiments, columns of table.csv
  /// The name in files of earlier releases, which are still read; nullptr if it never changed.
  const char* former_name = nullptr;
  const char* title = name;     ///< on axes and in captions, without its unit
  const char* heading = title;  ///< of a column, short
  Quantity quantity = Quantity::ratio;
  int decimals = 3;  ///< shown in tables
  Ideal ideal = {0};
  Better better = Better::smaller;
  /// The metric that measures the distance from the ideal in each frame, where the distance of the
  /// means is no substitute.
  Metric distance = metric;
  Threshold threshold = Threshold::none;  ///< how far `check` lets the means of two builds differ
  bool published = false;                 ///< one of the four metrics of the paper's tables
  bool headline = false;                  ///< has a column in the terminal's table
  const char* legend = "";                ///< how to read it, with its source; after "heading: "
  MetricFormula* formula = nullptr;

  /// Whether it is of the detected contacts, not of the image itself. Wide tables are divided
  /// there.
  constexpr bool of_contacts() const { return threshold == Threshold::contact; }
};

/// Share of a measured change of the voltages that an image explains by its linear response on the
/// uniform sheet, with its amplitude and the level of the whole sheet fitted. Needs no truth, and
/// is the same for every method.
class ExplainedChange {
 public:
  /// `reference` [channels] V, which a change of the sheet's level multiplies.
  ExplainedChange(const Sensor& sensor, const Eigen::VectorXd& reference);

  /// 1 - min over a, b of |change - a J image - b reference| / |change|, 0 ... 1. `change`
  /// [channels] V, `image` [pixels] S/m, all finite. No value if the change is zero.
  std::optional<double> of(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           const Eigen::Ref<const Eigen::RowVectorXd>& image) const;

 private:
  RowMajorMatrix jacobian_;  ///< [channels, pixels]
  Eigen::VectorXd reference_;
};

}  // namespace ertbench
