#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/ktc2023/instrument.h"

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

/// One measurement of the competition, with the empty tank's that belongs to it.
struct KtcTarget {
  std::string name;        ///< "2", of a folder of its own level "3.2"
  int level = 1;           ///< 1 ... 7; level k lacks electrodes 1 ... 2(k - 1)
  bool any_level = false;  ///< whole, so that it can stand for every level
  std::filesystem::path reference;
  KtcPatterns patterns;
  Eigen::VectorXd voltages;       ///< [channels], NaN where missing
  std::optional<ClassMap> truth;  ///< [256, 256], row 0 on top
};

/// The empty tank, its patterns and voltages: "Injref", "Mpat", "Uelref".
struct KtcReference {
  KtcPatterns patterns;
  Eigen::VectorXd voltages;
};
KtcReference read_ktc_reference(const std::filesystem::path& file);

/// All targets below a folder, by level and name. Files count by their names wherever they lie:
/// ref.mat, dataN.mat ("Inj", "Uel") and, optional, a truth ("truth"): trueN.mat, "true N.mat",
/// N_true.mat. Their level is the number in the name of their folder, "level3"; without one they
/// are whole targets of the training set. Throws InputError naming file and remedy.
std::vector<KtcTarget> read_ktc_targets(const std::filesystem::path& folder);

}  // namespace ertbench
