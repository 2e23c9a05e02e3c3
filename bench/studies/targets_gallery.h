#pragma once

#include <filesystem>
#include <string>

#include "bench/report/report.h"
#include "bench/studies/targets.h"

namespace ertbench {

/// `folder`/NAME_gallery (D4): a row for each number of contacts, a column for each solver; the
/// true footprints and the places that were found.
ReportFigure targets_gallery(const TargetCircumstances& circumstances, const TargetResults& results,
                             const std::string& title, const std::filesystem::path& folder);

}  // namespace ertbench
