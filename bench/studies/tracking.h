#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/studies/study.h"
#include "bench/studies/tracking_run.h"
#include "bench/table/table.h"

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

/// A row a solver.
TableSection tracking_table(const TrackingCondition& condition, const std::string& law);

/// Which frame rate is enough: a row a solver, a column a speed; none where no speed was measured
/// at two frame rates or more.
std::vector<TableSection> frame_rate_tables(std::span<const TrackingCondition> conditions,
                                            const std::string& law);

/// All numbers and the ends of their intervals, for programs: a row for each condition and solver.
TableSection tracking_data(std::span<const TrackingCondition> conditions, const std::string& law);

}  // namespace ertbench
