#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/studies/collision_detectors.h"
#include "bench/studies/study.h"

namespace ertbench {

/// D.5: did we hit something? Alarms by the largest |δσ| of an image, with thresholds that are set
/// on frames in which nothing touches; what they miss, how often they are false, and what becomes
/// of an arm that stops by them.
Study collision_study(const StudyInput& input);

/// Its tables, numbers, files and figures.
Study study_of_collision(const std::string& name, const CollisionResults& results);

/// Detection against force, detection against false alarms, and peak force against speed.
std::vector<StudyFigure> collision_figures(const std::shared_ptr<const CollisionResults>& results);

}  // namespace ertbench
