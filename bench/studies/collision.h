#pragma once

#include <memory>
#include <vector>

#include "bench/studies/collision_detectors.h"
#include "bench/studies/study.h"

namespace ertbench {

/// D.5: did we hit something? Alarms by the largest |δσ| of an image, with thresholds that are set
/// on frames in which nothing touches; what they miss, how often they are false, and what becomes
/// of an arm that stops by them.
Study collision_study(const StudyInput& input);

/// False alarms, thresholds, least forces and the arm's runs; CSV files of these, and of what the
/// figures show.
void add_collision_tables(const CollisionResults& results, StudySection& section);
/// All numbers, for summary.json.
nlohmann::json collision_json(const CollisionResults& results);

/// Detection against force, detection against false alarms, and peak force against speed.
std::vector<StudyFigure> collision_figures(const std::shared_ptr<const CollisionResults>& results);

}  // namespace ertbench
