#pragma once

#include <filesystem>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/fidelity_row.h"

namespace ertbench {

/// fidelity.csv, fidelity.md, fidelity.svg and .png, with provenance, in the folder; the table on
/// standard output.
void report_fidelity(const Experiment& experiment, const std::vector<FidelityRow>& rows,
                     const std::filesystem::path& folder);

}  // namespace ertbench
