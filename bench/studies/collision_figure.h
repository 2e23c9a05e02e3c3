#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/report/report.h"
#include "bench/studies/collision_detectors.h"

namespace ertbench {

/// Draws `stem`_force (detection against force), `stem`_curve (detection against false alarms) and
/// `stem`_arm (peak force against speed).
std::vector<ReportFigure> collision_figures(const CollisionResults& results,
                                            const std::string& title,
                                            const std::filesystem::path& stem);

}  // namespace ertbench
