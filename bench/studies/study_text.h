#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/studies/error_statistics.h"
#include "bench/table/table.h"
#include "forward/data/noise.h"

namespace ertbench {

std::string force_text(const std::pair<double, double>& force_N);  ///< "5 N", "1 to 10 N"
std::string noise_text(const Noise& noise);                        ///< "50 dB absolute", "no noise"
/// An experiment's title for the heading of a figure, which names the law among its conditions:
/// "Collision" of "Collision, rising law".
std::string without_law(const std::string& title);

/// Writes `folder`/`name`.md, and `rows` for programs: `folder`/`name`.csv.
void write_study_tables(const Table& table, const TableSection& rows,
                        const std::filesystem::path& folder, const std::string& name);

/// Three cells for programs: the value and the ends of its interval, empty where there is none.
std::vector<Cell> exact_cells(const std::optional<Estimate>& estimate);
/// The titles of three such columns: "mean_mm", "mean_mm_low", "mean_mm_high".
std::vector<Column> exact_columns(const std::string& name);

}  // namespace ertbench
