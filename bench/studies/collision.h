#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bench/studies/collision_detectors.h"
#include "bench/studies/study.h"

namespace ertbench {

/// All that the study's tables and figures show.
struct CollisionResults {
  std::string condition;  ///< "falling law, 50 dB absolute"; with the noises where they differ
  double per_hour = 10;   ///< false alarms that were asked for
  ArmSettings arm;
  double frame_rate = 125;               ///< of the arm's frames, 1/s
  double calibration_hours = 0;          ///< of quiet frames
  std::vector<int> region_areas;         ///< [regions] how many of the areas
  std::optional<std::size_t> reference;  ///< bin of force that the operating curves are of
  /// Both rules of each solver, in the order of the experiment, then the norm of the voltages.
  std::vector<Detector> detectors;
  ArmOutcome undelayed;  ///< of a skin that raises its alarm at the very onset
};

/// D.5: did we hit something? Alarms by the largest |δσ| of an image, with thresholds that are set
/// on frames in which nothing touches; what they miss, how often they are false, and what becomes
/// of an arm that stops by them.
class Collision : public StudyResult {
 public:
  explicit Collision(const StudyInput& input);

  nlohmann::json summary() const override;
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string name_;
  CollisionResults results_;
};

}  // namespace ertbench
