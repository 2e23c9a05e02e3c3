#pragma once

#include <filesystem>
#include <string>

#include "bench/report/report.h"
#include "bench/studies/targets.h"

namespace ertbench {

/// `folder`/NAME: recall and ghosts against the number of contacts, share told apart against the
/// gap. `title` is the experiment's.
ReportFigure targets_chart(const TargetCircumstances& circumstances, const TargetResults& results,
                           const std::string& title, const std::filesystem::path& folder);

/// `folder`/NAME_gallery (D4): a row for each number of contacts, a column for each solver; the
/// true footprints and the places that were found.
ReportFigure targets_gallery(const TargetCircumstances& circumstances, const TargetResults& results,
                             const std::string& title, const std::filesystem::path& folder);

}  // namespace ertbench
