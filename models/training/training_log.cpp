#include "models/training/training_log.h"

#include <fstream>
#include <nlohmann/json.hpp>

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

nlohmann::json TrainingLog::rows() const { return rows_; }

void TrainingLog::set_rows(const nlohmann::json& rows) {
  rows_ = rows.get<std::vector<std::vector<double>>>();
}

}  // namespace ertbench
