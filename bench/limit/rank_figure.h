#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "bench/limit/limit_run.h"

namespace ertbench {

/// Histograms of the ranks of the truths among the samples of their posteriors (Talts et al. 2018),
/// a row for each set under the prior of its own scenes, a column for each of limit_ranks: flat
/// where the posteriors are right. `stem`.svg and `stem`.png. Throws InputError where gnuplot is
/// missing or a file cannot be written.
void draw_rank_figure(std::span<const SetLimit> limits, const std::string& title,
                      const std::filesystem::path& stem);

}  // namespace ertbench
