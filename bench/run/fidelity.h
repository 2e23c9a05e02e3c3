#pragma once

#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/fidelity_row.h"

namespace ertbench {

/// Scenes whose time is taken as one.
inline constexpr int fidelity_block = 16;  // two of the condensation's eight lanes

/// Draws the scenes of every dataset and computes them with "grid": "auto" and with the grids of
/// 24, 48, 96 and 192, in turn, block by block, on one thread. Errors are against the border
/// integral equation at a thousandth of the bound. "smooth" are scenes of whole discs and ellipses
/// that do not touch; "other" those with corners, overlaps, or contacts cut by the sheet's border.
std::vector<FidelityRow> measure_fidelity(const Experiment& experiment, int scenes);

}  // namespace ertbench
