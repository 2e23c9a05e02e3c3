#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/folds/folds_stage.h"
#include "bench/record/experiment_results.h"
#include "bench/studies/error_statistics.h"

namespace ertbench {

/// Location errors of some presses, mm. A press that no contact was found for counts as one that
/// was guessed to be in the middle of the sheet.
struct PressErrors {
  std::string title;  ///< of a part of the presses: "depth_mm 10", "0 to 21 mm"; of all empty
  std::size_t presses = 0;
  std::size_t missed = 0;  ///< of which no contact was found
  std::optional<Estimate> mean, median, p95;
  std::optional<double> worst;
};

/// What one solver did after learning from so many presses.
struct PressLevel {
  std::uint64_t presses = 0;
  std::string failure;  ///< why a fold has no result; else empty
  PressErrors all;
  std::vector<double> fold_means;  ///< mm, of the folds that were run
  std::vector<PressErrors> by_strength;
  std::vector<PressErrors> by_place;  ///< rings around the middle
  /// Mean |error| of the strength in the units of the file (depth in mm), where it was told apart.
  std::optional<Estimate> strength;
  double fit_s = 0;  ///< mean
};

struct PressSolver {
  std::string label;
  std::string failure;
  std::vector<PressLevel> levels;      ///< by presses, ascending
  std::vector<HeldOutPress> held_out;  ///< of the last level, all folds
};

/// Where was it pressed? Measured presses at known places, by cross-validation (Folds): errors of
/// the places that solvers find on presses which they have not seen, by number of presses learned
/// from, strength and place. D.1 on hardware.
class Presses : public StudyResult {
 public:
  Presses(const Folds& folds, const std::vector<FoldsOutcome>& outcomes);

  nlohmann::json summary() const override;
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string file_;           ///< of the frames
  std::string strength_name_;  ///< "depth_mm"; empty where all presses are alike
  double unit_strength_ = 1;   ///< of the file's numbers for a strength of 1
  double radius_mm_ = 0;       ///< of the sheet
  std::vector<Eigen::Vector2d> border_mm_;
  std::vector<Eigen::Vector2d> electrodes_mm_;
  int folds_ = 0;
  std::vector<std::uint64_t> presses_;
  PressErrors middle_;                     ///< of guessing the middle of the sheet
  std::optional<Estimate> mean_strength_;  ///< mean |error| of guessing the mean strength
  std::vector<PressSolver> solvers_;
};

}  // namespace ertbench
