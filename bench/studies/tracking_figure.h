#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "bench/report/report.h"
#include "bench/studies/tracking_run.h"

namespace ertbench {

/// RMS distance and share of characters read back, by solver: over the speed for each frame rate,
/// and over the frame rate for speeds that were measured at some only. `stem`.svg and .png.
ReportFigure tracking_sweep(std::span<const TrackingCondition> conditions, const std::string& law,
                            const std::string& title, const std::filesystem::path& stem);

/// Written and tracked characters, a column a solver.
ReportFigure tracking_gallery(const TrackingCondition& condition, const std::string& law,
                              const std::string& title, const std::filesystem::path& stem);

}  // namespace ertbench
