#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/studies/collision_detectors.h"
#include "bench/table/table.h"

namespace ertbench {

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
