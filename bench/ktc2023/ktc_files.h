#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/ktc2023/instrument.h"
#include "bench/ktc2023/ktc_score.h"

namespace ertbench {

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
