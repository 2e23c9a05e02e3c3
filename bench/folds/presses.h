#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/study_spec.h"
#include "bench/studies/study.h"

namespace ertbench {

/// One press that nobody had seen, and where a solver put it; mm from the origin of the domain
/// units.
struct HeldOutPress {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  double strength = 0;                      ///< 1 - conductivity ratio of the true contact
  std::optional<Eigen::Vector2d> found_mm;  ///< nothing where no contact was detected
  /// Integral of |δσ| over the detected contact, over that of a contact of the true one's size and
  /// ratio 0; 0 where none was found.
  double found_strength = 0;

  bool operator==(const HeldOutPress&) const = default;
};

/// Results of a solver that learned from `presses`, on the share held out.
struct FoldRun {
  std::uint64_t presses = 0;
  std::string message;  ///< why it could not be fitted; else empty
  double fit_s = 0;
  std::vector<HeldOutPress> held_out;
};

/// `{"schema", "key", "runs": [{"presses", "message", "fit_s", "held_out": [[x, y, strength, found
/// x, found y, found strength], ...]}]}` of one fold, nulls where nothing was found.
using FoldRecord = std::vector<FoldRun>;

/// Without the key.
nlohmann::json to_json(const FoldRecord& record);
/// Throws an exception of any kind where the JSON is not such a record.
FoldRecord fold_record_from_json(const nlohmann::json& object);

/// Outcome of one label's folds: [Folds::total()] of its first seed.
struct FoldsOutcome {
  std::string label;
  std::vector<FoldRecord> folds;  ///< empty where it was not run
  std::string failure;            ///< of the first that was not; else empty
};

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
};

/// Where was it pressed? Measured presses at known positions, by cross-validation (Folds):
/// localisation errors on presses that the solvers have not seen, by number of presses learned
/// from, strength and place, of all skins and of each. D.1 on hardware.
Study presses_study(const Folds& folds, const std::vector<FoldsOutcome>& outcomes);

}  // namespace ertbench
