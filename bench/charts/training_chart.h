#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/analysis/training_curves.h"

namespace ertbench {

/// One training run.
struct TrainingRun {
  std::string title;  ///< "seed 2"; may be empty where it is the only one
  TrainingCurves curves;
  std::optional<double> kept_epoch;  ///< whose weights were kept
};

/// How a network was trained, once for each seed.
struct TrainingChart {
  std::string title;
  std::vector<TrainingRun> runs;
};

/// Draws `stem`.svg and `stem`.png over the epochs: above all losses (logarithmic), the
/// discriminator's among them, below what begins with "validation", and between the two, where
/// there are any, the shares of patches that a discriminator judged right (what begins with
/// "discriminator_right"), 0 to 1. Each column has a colour and a mark of its own, the runs go from
/// dark to light; dots mark the epochs that were kept. Columns "learning_rate" and "seconds" are
/// left out.
/// Of a loss that is negative somewhere the absolute value is drawn, and the key says so.
/// Throws InputError where gnuplot is missing or a file cannot be written.
void draw_training_chart(const TrainingChart& chart, const std::filesystem::path& stem);

}  // namespace ertbench
