#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/record/experiment_results.h"
#include "bench/report/report.h"

namespace ertbench {

/// Copies the logs of one label into `folder`/`stem`.csv and draws them as `folder`/`label`.svg and
/// .png. Does nothing where there is no log; one that cannot be read is named in a warning. Returns
/// the chart, where there is one.
std::optional<ReportFigure> write_training_results(const std::string& label,
                                                   const std::vector<TrainingSource>& sources,
                                                   const std::filesystem::path& folder);

/// The chart of a label that write_training_results has drawn before; nothing where there is none.
std::optional<ReportFigure> training_figure(const std::string& label,
                                            const std::filesystem::path& folder);

}  // namespace ertbench
