#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/fidelity/fidelity_record.h"
#include "bench/record/experiment_results.h"

namespace ertbench {

/// Error against time a scene, a panel for each dataset, above the sizes of the systems.
void draw_fidelity_chart(const std::vector<FidelityRow>& rows, const std::string& title,
                         const std::filesystem::path& stem);

/// fidelity.csv, fidelity.md, fidelity.svg and .png, with provenance, in the folder; the table on
/// standard output. Datasets that failed are named below the table.
void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const Builds& builds, const std::filesystem::path& folder);

}  // namespace ertbench
