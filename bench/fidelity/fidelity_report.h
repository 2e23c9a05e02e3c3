#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/fidelity/fidelity_record.h"
#include "bench/record/experiment_results.h"

namespace ertbench {

/// Draws error against time per scene, one panel for each dataset, with the sizes of the systems.
void draw_fidelity_chart(const std::vector<FidelityRow>& rows, const std::string& title,
                         const std::filesystem::path& stem);

/// Writes fidelity.csv, fidelity.md, fidelity.svg and .png with provenance into the folder and
/// prints the table. Datasets that failed are named below it.
void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const Builds& builds, const std::filesystem::path& folder);

}  // namespace ertbench
