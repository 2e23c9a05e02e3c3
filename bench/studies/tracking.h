#pragma once

#include <string>
#include <vector>

#include "bench/studies/study.h"
#include "bench/studies/tracking_scores.h"

namespace ertbench {

/// D.4: along which path? A finger writes characters; the places that a solver's contacts and a
/// tracker give are held against those of the finger, at the time at which they are known.
class Tracking : public StudyResult {
 public:
  explicit Tracking(const StudyInput& input);

  nlohmann::json summary() const override;
  std::vector<Headline> headlines() const override;
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string name_;
  std::string law_;
  std::vector<TrackingCondition> conditions_;
};

}  // namespace ertbench
