#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/record/experiment_results.h"

namespace ertbench {

/// Copies the logs of one label into `folder`/`stem`.csv and draws them as `folder`/`label`.svg and
/// .png. Does nothing where there is no log; one that cannot be read is named in a warning. Returns
/// whether there is a chart.
bool write_training_results(const std::string& label, const std::vector<TrainingSource>& sources,
                            const std::filesystem::path& folder);

}  // namespace ertbench
