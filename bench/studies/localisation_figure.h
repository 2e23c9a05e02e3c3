#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/report/report.h"
#include "bench/studies/localisation.h"

namespace ertbench {

/// The targets of one set, the mean places found for them by each solver, and the bound: the
/// paper's figure D1. `stem`.svg and .png.
ReportFigure localisation_map(const LocalisedSet& set, double side_mm, const std::string& law,
                              const std::string& title, const std::filesystem::path& stem);

/// Median and 95 % of the errors of all sets by solver.
ReportFigure localisation_overview(const std::vector<LocalisedSet>& sets, const std::string& law,
                                   const std::string& title, const std::filesystem::path& stem);

}  // namespace ertbench
