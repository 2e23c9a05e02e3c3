#pragma once

#include <filesystem>
#include <string>

#include "bench/analysis/speed_accuracy.h"

namespace ertbench {

/// Draws `stem`.svg and `stem`.png: on the left the median error against the time of one frame (p50
/// with a whisker to p99, 95 % interval of the median), on the right against the frames per second
/// in batches. A line joins each family, a staircase the configurations that no faster one beats. A
/// configuration that failed or did not converge is hollow or, without numbers, named above the
/// chart. Throws InputError where gnuplot is missing or a file cannot be written.
void draw_speed_figure(const SpeedAccuracy& chart, const std::string& title,
                       const std::filesystem::path& stem);

}  // namespace ertbench
