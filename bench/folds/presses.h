#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/folds/folds_stage.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"

namespace ertbench {

/// Location errors of some presses, mm. A missed press counts as one that was guessed to
/// be in the middle of the sheet.
struct PressErrors {
  std::string title;  ///< of a part of the presses: "depth_mm 10", "0 to 21 mm"; of all empty
  std::size_t presses = 0;
  std::size_t missed = 0;  ///< presses without a detected contact
  std::optional<Estimate> mean, median, p95;
  std::optional<double> worst;
};

/// Results of one solver after learning from so many presses.
struct PressLevel {
  std::uint64_t presses = 0;
  std::string failure;  ///< why a fold has no result; else empty
  PressErrors all;
  std::vector<double> fold_means;  ///< mm, of the folds that were run
  std::vector<PressErrors> by_strength;
  std::vector<PressErrors> by_place;  ///< rings around the middle
  /// Mean |error| of the strength in the units of the file (depth in mm), where presses differ in
  /// it.
  std::optional<Estimate> strength;
  double fit_s = 0;  ///< mean
};

struct PressSolver {
  std::string label;
  std::string failure;
  std::vector<PressLevel> levels;      ///< by presses, ascending
  std::vector<HeldOutPress> held_out;  ///< of the last level, all folds
};

/// The presses of all solvers, and the sheet that they are drawn on.
struct PressResults {
  PressErrors middle;                     ///< of guessing the middle of the sheet
  std::optional<Estimate> mean_strength;  ///< mean |error| of guessing the mean strength
  std::vector<PressSolver> solvers;
  std::vector<Eigen::Vector2d> border_mm;
  std::vector<Eigen::Vector2d> electrodes_mm;
  double radius_mm = 0;  ///< of the sheet
};

/// Where was it pressed? Measured presses at known positions, by cross-validation (Folds):
/// localisation errors on presses that the solvers have not seen, by number of presses learned
/// from, strength and place. D.1 on hardware.
Study presses_study(const Folds& folds, const std::vector<FoldsOutcome>& outcomes);

/// Location error over the number of presses learned from, a line a solver with the least and the
/// largest mean of a fold as its band, and guessing the middle as a level.
StudyFigure press_curve(const std::shared_ptr<const PressResults>& results);
/// A panel a solver: a line from each true position to the estimated one, over the sheet.
StudyFigure press_map(const std::shared_ptr<const PressResults>& results);

}  // namespace ertbench
