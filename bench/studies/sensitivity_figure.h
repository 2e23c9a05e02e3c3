#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/report/report.h"
#include "bench/studies/sensitivity.h"

namespace ertbench {

/// The largest |δσ| over the background against the force, a panel a solver, a line a region, and
/// the map of the regions: the paper's figures D3 and D2. `stem`.svg and .png.
ReportFigure sensitivity_curves(const SensitivitySet& set, const std::vector<int>& region_of,
                                double background, const std::string& law, const std::string& title,
                                const std::filesystem::path& stem);

/// Error of the calibrated force against the force, by solver.
ReportFigure force_errors(const SensitivitySet& set, const std::string& law,
                          const std::string& title, const std::filesystem::path& stem);

}  // namespace ertbench
