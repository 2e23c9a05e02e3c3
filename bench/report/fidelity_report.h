#pragma once

#include <filesystem>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/experiment_results.h"

namespace ertbench {

/// fidelity.csv, fidelity.md, fidelity.svg and .png, with provenance, in the folder; the table on
/// standard output. Datasets that failed are named below the table.
void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const Builds& builds, const std::filesystem::path& folder);

}  // namespace ertbench
