#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace ertbench
