#pragma once

#include <filesystem>
#include <string>

#include "bench/report/report.h"
#include "bench/studies/consistency.h"

namespace ertbench {

/// The path that each method saw, on the sheet with its electrodes; early frames dark, late ones
/// light. `stem`.svg and .png.
ReportFigure path_figure(const ConsistentSet& set, const Sensor& sensor, const std::string& title,
                         const std::filesystem::path& stem);

}  // namespace ertbench
