#pragma once

#include <filesystem>

#include "bench/load/load_run.h"
#include "bench/table/table.h"

namespace ertbench {

/// A row for each solver: the times of a frame by itself, then for each deadline the highest rates
/// with fixed and with Poisson arrivals.
Table load_table(const LoadResults& results);

/// The rates over the deadlines, arrivals at a fixed rate on the left and Poisson ones on the
/// right, as `stem`.svg and `stem`.png. Returns whether it was drawn (draw_or_say).
bool draw_load(const LoadResults& results, const std::filesystem::path& stem);

/// load.json, load.md, load.csv and the figure `load` in `folder`. Returns whether it was drawn.
bool write_load(const LoadResults& results, const std::filesystem::path& folder);

}  // namespace ertbench
