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

struct ContactScore;

/// One image beside the truth: what the formulas of the metrics are given. All pixels are finite.
struct ScoredImage {
  const Sensor& sensor;
  const Scene& scene;
  const Eigen::RowVectorXd& conductivity;  ///< [pixels] S/m, true
  const Eigen::RowVectorXd& true_change;   ///< [pixels] S/m
  const Eigen::RowVectorXd& change;        ///< [pixels] S/m, estimated
  const ContactScore& contacts;            ///< for metrics of contacts alone

  bool truth_is_empty() const;
  bool is_empty() const;
};

/// Where the contacts are: the centre of a contact that is alone and whole on the sheet, else the
/// centroid of the true change (C4), domain units; nothing where that has none.
std::optional<Eigen::Vector2d> true_centre(const Sensor& sensor, const Scene& scene,
                                           const Eigen::RowVectorXd& true_change);

/// (C2) of one image of changes, %; undefined of an empty image.
std::optional<double> resolution_of(const Sensor& sensor, const Eigen::RowVectorXd& change);

}  // namespace ertbench

/// The formulas of the metrics. dσ is the true change of the conductivity, dσ^ the estimated one;
/// C1 ... C5 and D.1 are numbers in the supplement of the DD-ERT paper (Zheng et al.).
///
/// An image is empty where no |dσ| is above 1e-9 of the background. What a formula does not define
/// has no value; images with pixels that are not finite reach no formula.
namespace ertbench {

struct ScoredImage;

using MetricFormula = std::optional<double>(const ScoredImage&);

/// sum(dσ^) / sum(dσ) (C1). Undefined where the truth is empty or its sum cancels: |sum| <= 1e-3
/// sum|.|.
MetricFormula amplitude_response;

/// (1 - sqrt((A50 - A_pixel) / A_total)) 100 of the image (C2), %. Undefined of an empty image.
MetricFormula image_resolution;

/// |RES - RES of the truth|, %. Undefined where either image is empty.
MetricFormula resolution_error;

/// Distance of the centroid of dσ^ from the true centre (C3, C4), domain units. Undefined where
/// either image is empty or its weights cancel, |sum| <= 1e-3 sum|.|: positive and negative parts
/// are then equal to a thousandth, and the centroid, amplified 1000 times, may lie anywhere.
///
/// The true centre is the contact's where the scene has exactly one and it lies wholly within the
/// sheet; otherwise the centroid of the true change.
MetricFormula position_error;

/// The position error after what is under 25 % of the largest |dσ^| is set to zero (D.1).
MetricFormula position_error_of_the_peak;

/// ||σ^ - σ|| / ||σ||, absolute conductivities (C5).
MetricFormula relative_image_error;

/// ||dσ^ - dσ|| / ||dσ||; the empty image scores 1. Undefined where the truth is empty.
MetricFormula relative_error_of_change;

/// Structural similarity of dσ^ and dσ (Wang, Bovik, Sheikh and Simoncelli 2004), the mean over all
/// pixels of
///
///     (2 μ μ^ + C1) (2 cov + C2) / ((μ² + μ^² + C1) (var + var^ + C2))
///
/// with the mean values, variances and covariance of a window around the pixel: 11 x 11 pixels,
/// weighted by a Gaussian of standard deviation 1.5 pixels whose weights sum up to 1, and C1 =
/// (.01 L)², C2 = (.03 L)². At the border of the sheet the window is what of it is on the sheet,
/// weights again with sum 1: of 24 x 24 pixels only 14 x 14 have a whole window, and contacts near
/// the border would go unseen. The dynamic range L is the span of the true change, no change
/// included: max(dσ, 0) - min(dσ, 0), so that no unit and no strength of contact changes the
/// result. Undefined where the truth is empty.
MetricFormula structural_similarity;

/// Pearson's correlation coefficient of dσ^ and dσ over the pixels. Undefined where one of the two
/// is constant: no pixel further from the mean than 1e-9 of the background.
MetricFormula correlation_coefficient;

// Of the contacts that were found in the frame, see ContactScore for their definitions.

/// True contacts that a found one is matched with.
MetricFormula contacts_found;

/// Found contacts that are matched with no true one.
MetricFormula ghosts;

/// Matched contacts over found ones. Undefined where none was found.
MetricFormula precision_of_contacts;

/// Matched contacts over true ones. Undefined where there is none.
MetricFormula recall_of_contacts;

/// Mean distance of matched contacts, mm. Undefined where there is none.
MetricFormula location_error;

/// |found contacts - true contacts|.
MetricFormula count_error;

/// OSPA distance of order 1 of found and true contacts (Schuhmacher, Vo and Vo 2008), mm.
MetricFormula ospa_distance;

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

/// What is known of a metric: the columns of the table of metrics (metric_entries.h).
namespace ertbench {

/// What is measured on one image.
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
  found,
  ghosts,
  precision,
  recall,
  location_error_mm,
  count_error,
  ospa_mm
};

/// Of what kind a metric's values are, and so how they change with the size of the sheet.
enum class Quantity {
  ratio,        ///< without a unit, about 1 in size; the same on any sheet
  percent,      ///< the same in hundredths
  length,       ///< domain units, in which the sheet is 2 x 2; grows with the sheet
  millimetres,  ///< a length on the sheet
  number,       ///< how many
};

/// Which of two values is the better.
enum class Better {
  smaller,  ///< an error: the ideal is 0, and no value is below it
  larger,   ///< the ideal is the largest value there is
  nearer,   ///< to the ideal, from either side
};

/// What a perfect image scores.
struct Ideal {
  double value = 0;
  /// The ideal is what the true images score; `value` stands in where they were not scored.
  bool of_truth = false;
};

/// By how much the value of one frame jumps where a pixel changes sides of a threshold.
enum class Threshold {
  none,      ///< no pixel is compared with a threshold
  area,      ///< counts the pixels above the threshold (C2)
  centroid,  ///< is a place to which only the pixels above the threshold contribute (D.1)
  contact,   ///< counts contacts, or measures how far they are; a pixel may make or end one
};

struct MetricEntry {
  Metric metric;
  const char* name;     ///< in files: summary.json, experiments, columns of table.csv
  const char* title;    ///< on axes and in captions, without its unit
  const char* heading;  ///< of a column, short
  Quantity quantity;
  int decimals;  ///< with which it is shown
  Ideal ideal;
  Better better;
  /// The metric that measures the distance from the ideal frame by frame, for which the distance of
  /// the means is no substitute; itself where there is none.
  Metric distance;
  Threshold threshold;  ///< how far a mean may lie from that of another build (the check)
  bool published;       ///< one of the paper's four, which its tables give
  bool headline;        ///< has a column in the terminal's table
  /// Of the contacts that were found (bench/contacts), not of the image itself; such metrics are a
  /// part of their own where a table is wide.
  bool of_contacts = false;
  const char* legend = "";  ///< how it is to be read, with its source; follows "heading: "
  MetricFormula* formula = nullptr;
};

/// How much of a measured change of the voltages an image explains: what its linear response on the
/// uniform sheet, at the best amplitude and with the level of the whole sheet free, leaves of the
/// change's norm. Needs no truth, and is the same for every method.
class ExplainedChange {
 public:
  /// `reference` [channels] V, which a change of the sheet's level multiplies.
  ExplainedChange(const Sensor& sensor, const Eigen::VectorXd& reference);

  /// 1 - min over a, b of |change - a J image - b reference| / |change|, 0 ... 1. `change`
  /// [channels] V, `image` [pixels] S/m, all finite. Nothing where the change is zero.
  std::optional<double> of(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           const Eigen::Ref<const Eigen::RowVectorXd>& image) const;

 private:
  RowMajorMatrix jacobian_;  ///< [channels, pixels]
  Eigen::VectorXd reference_;
};

}  // namespace ertbench
