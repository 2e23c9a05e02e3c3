#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/record/experiment_results.h"
#include "bench/report/report.h"

namespace ertbench {

/// What a learned solver wrote while it was trained: `training.csv` in its work folder, a line of
/// names, the first of them "epoch", then a line of numbers for each epoch.
struct TrainingCurves {
  std::vector<std::string> columns;         ///< "epoch", "loss", "validation_error", ...
  std::vector<std::vector<double>> values;  ///< [columns][epochs]; may hold NaN and infinity

  std::size_t epochs() const { return values.empty() ? 0 : values.front().size(); }
};

/// Reads one; an unfinished last line is left out. Throws InputError naming file and line.
TrainingCurves read_training_curves(const std::filesystem::path& file);

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

/// Copies the logs of one label into `folder`/`stem`.csv and draws them as `folder`/`label`.svg and
/// .png. Does nothing where there is no log; one that cannot be read is named in a warning. Returns
/// the chart, where there is one.
std::optional<ReportFigure> write_training_results(const std::string& label,
                                                   const std::vector<TrainingSource>& sources,
                                                   const std::filesystem::path& folder);

/// The chart of a label that write_training_results has drawn before; nothing where there is none.
std::optional<ReportFigure> training_figure(const std::string& label,
                                            const std::filesystem::path& folder);

}  // namespace ertbench
