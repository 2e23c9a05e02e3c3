#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/studies/collision_detectors.h"
#include "bench/studies/study.h"
#include "bench/table/table.h"

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

/// How the study was made, in a paragraph.
std::string collision_text(const CollisionResults& results);
/// How its tables are to be read.
std::vector<std::string> collision_notes(const CollisionResults& results);
/// False alarms, thresholds, least forces, the arm.
std::vector<TableSection> collision_tables(const CollisionResults& results);

/// Everything, with the intervals.
nlohmann::json collision_json(const CollisionResults& results);
/// What the figures show, for programs: NAME_force.csv, NAME_curve.csv and NAME_runs.csv.
void write_collision_data(const CollisionResults& results, const std::filesystem::path& folder,
                          const std::string& name);

}  // namespace ertbench
