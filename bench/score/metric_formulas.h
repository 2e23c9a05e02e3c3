#pragma once

#include <optional>

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

}  // namespace ertbench
