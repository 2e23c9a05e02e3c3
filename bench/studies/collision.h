#pragma once

#include <string>
#include <vector>

#include "bench/studies/collision_detectors.h"
#include "bench/studies/study.h"

namespace ertbench {

/// D.5: did we hit something? Alarms by the largest |δσ| of an image, with thresholds that are set
/// on frames in which nothing touches; what they miss, how often they are false, and what becomes
/// of an arm that stops by them.
class Collision : public StudyResult {
 public:
  explicit Collision(const StudyInput& input);

  nlohmann::json summary() const override;
  std::vector<Headline> headlines() const override;
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string name_;
  CollisionResults results_;
};

}  // namespace ertbench
