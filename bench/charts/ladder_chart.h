#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/analysis/ladder_results.h"

namespace ertbench {

/// One axis of the ladders for all solvers that climbed it: above, the share of failing frames over
/// the level, with the limit at which a solver counts as broken down; below, the median relative
/// error with whiskers from 5 to 95 %. The mildest level is on the left. More than eight solvers
/// are shared out over several such columns, on the same axes. Draws `stem`.svg and `stem`.png.
/// Throws InputError where gnuplot is missing or a file cannot be written.
void draw_ladder_chart(const Ladders& ladders, const LadderAxis& axis,
                       const std::vector<LadderOutcome>& outcomes,
                       const std::filesystem::path& stem);

}  // namespace ertbench
