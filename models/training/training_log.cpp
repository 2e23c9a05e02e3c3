#include "models/training/training_log.h"

#include <fstream>

#include "core/errors.h"
#include "core/replace_file.h"

namespace ertbench {

void TrainingLog::write(const std::filesystem::path& folder) const {
  const auto write = [&](const std::filesystem::path& aside) {
    std::ofstream out(aside);
    out.precision(9);
    const char* separator = "";
    for (const std::string& column : columns_) {
      out << separator << column;
      separator = ",";
    }
    for (const std::vector<double>& row : rows_) {
      separator = "\n";
      for (const double value : row) {
        out << separator << value;
        separator = ",";
      }
    }
    out << "\n";
    out.close();
    if (!out) throw InputError(aside.string() + ": cannot be written; is the disk full?");
  };
  replace_file(folder / "training.csv", write, folder / "training.csv.part");
}

RowMajorMatrix TrainingLog::rows() const {
  RowMajorMatrix out(static_cast<Eigen::Index>(rows_.size()),
                     static_cast<Eigen::Index>(columns_.size()));
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const std::vector<double>& row = rows_[static_cast<std::size_t>(i)];
    out.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), out.cols());
  }
  return out;
}

void TrainingLog::set_rows(const RowMajorMatrix& rows) {
  rows_.clear();
  for (const auto& row : rows.rowwise()) rows_.emplace_back(row.begin(), row.end());
}

}  // namespace ertbench
