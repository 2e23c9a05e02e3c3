#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/folds/presses.h"
#include "bench/report/report.h"

namespace ertbench {

/// Location error over the number of presses learned from, a line a solver with the least and the
/// largest mean of a fold as its band, and guessing the middle as a level.
ReportFigure press_curve(const std::vector<PressSolver>& solvers, const PressErrors& middle,
                         const std::string& title, const std::filesystem::path& stem);

/// What of the sheet is drawn, mm from its middle.
struct SheetOutline {
  std::vector<Eigen::Vector2d> border_mm;
  std::vector<Eigen::Vector2d> electrodes_mm;
  double radius_mm = 0;
};

/// A panel a solver: a line from each true place to the one found, over the sheet.
ReportFigure press_map(const std::vector<PressSolver>& solvers, const SheetOutline& sheet,
                       const std::string& title, const std::filesystem::path& stem);

}  // namespace ertbench
