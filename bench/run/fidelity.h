#pragma once

#include <cstdint>
#include <functional>

#include "bench/record/fidelity_record.h"

namespace ertbench {

/// Draws the dataset's first scenes, at most so many, and computes them with "grid": "auto" and
/// with the grids of 24, 48, 96 and 192, in turn, block by block, on one thread. Errors are against
/// the border integral equation at a thousandth of the bound. Blank scenes are left out: every
/// model is exact there. `progress` is told the scenes done and to do.
FidelityRecord measure_fidelity(
    const DatasetSpec& dataset, int scenes,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress);

}  // namespace ertbench
