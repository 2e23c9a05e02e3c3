#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// One line for each epoch of a training, written as training.csv into the work folder:
/// `epoch,loss,<terms>,validation_error,learning_rate,seconds`; losses are means over the epoch's
/// steps, seconds the epoch's own.
class TrainingLog {
 public:
  explicit TrainingLog(std::vector<std::string> columns) : columns_(std::move(columns)) {}

  void add(std::vector<double> row) { rows_.push_back(std::move(row)); }
  void write(const std::filesystem::path& folder) const;

  RowMajorMatrix rows() const;  ///< [epochs, columns]
  void set_rows(const RowMajorMatrix& rows);

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<double>> rows_;
};

}  // namespace ertbench
