#pragma once

#include <Eigen/Core>

namespace ertbench {

/// A segmented image of KTC2023, row 0 on top: 0 water, 1 resistive, 2 conductive.
using ClassMap = Eigen::MatrixXi;

/// Mean structural similarity of two images of one size (Wang et al. 2004) under a Gaussian window
/// of `width` pixels that ends at twice as many, its weights normalised at the border; constants
/// 1e-4 and 9e-4.
double mean_similarity(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double width = 80);

/// The competition's score of a target: the mean of the similarities of conductive and of
/// resistive pixels. 1 for equal maps.
double ktc_score(const ClassMap& truth, const ClassMap& map);

/// Segments an image at Otsu's two thresholds over its histogram of 256 bins; the largest class is
/// water, classes above it are conductive, those below it resistive.
ClassMap otsu_classes(const Eigen::MatrixXd& image);

}  // namespace ertbench
