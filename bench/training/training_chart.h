#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/record/experiment_results.h"
#include "bench/report/report.h"

namespace ertbench {

/// The training log of a learned solver, `training.csv` in its work folder: a line of column names,
/// the first of them "epoch", then a line of numbers for each epoch.
struct TrainingCurves {
  std::vector<std::string> columns;         ///< "epoch", "loss", "validation_error", ...
  std::vector<std::vector<double>> values;  ///< [columns][epochs]; may hold NaN and infinity

  std::size_t epochs() const { return values.empty() ? 0 : values.front().size(); }
};

/// Reads a log; an unfinished last line is left out. Throws InputError naming file and line.
TrainingCurves read_training_curves(const std::filesystem::path& file);

struct TrainingRun {
  std::string title;  ///< "seed 2"; may be empty for a single run
  TrainingCurves curves;
  std::optional<double> kept_epoch;  ///< the epoch whose weights were kept
};

/// The trainings of a network, one for each seed.
struct TrainingChart {
  std::string title;
  std::vector<TrainingRun> runs;
};

/// Draws `stem`.svg and `stem`.png over the epochs in up to three panels: all losses (logarithmic);
/// shares of patches that a discriminator judged right (columns "discriminator_right..."), if any;
/// and columns "validation...". Columns differ in colour and mark, runs go from dark to light, dots
/// mark the kept epochs. Columns "learning_rate" and "seconds" are left out. A loss with negative
/// values is drawn by its absolute value, which the key states. Throws InputError if gnuplot is
/// missing or a file cannot be written.
void draw_training_chart(const TrainingChart& chart, const std::filesystem::path& stem);

/// Copies the logs of one label into `folder`/`stem`.csv and draws them as `folder`/`label`.svg and
/// .png. Logs that cannot be read are named in a warning. Returns the chart; nothing without logs.
std::optional<ReportFigure> write_training_results(const std::string& label,
                                                   const std::vector<TrainingSource>& sources,
                                                   const std::filesystem::path& folder);

}  // namespace ertbench
