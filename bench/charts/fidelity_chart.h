#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/record/fidelity_row.h"

namespace ertbench {

/// Error against time a scene, a panel for each dataset, above the sizes of the systems.
void draw_fidelity_chart(const std::vector<FidelityRow>& rows, const std::string& title,
                         const std::filesystem::path& stem);

}  // namespace ertbench
