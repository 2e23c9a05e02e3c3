#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "bench/table/table.h"
#include "forward/data/noise.h"

namespace ertbench {

std::string force_text(const std::pair<double, double>& force_N);  ///< "5 N", "1 to 10 N"
std::string noise_text(const Noise& noise);                        ///< "50 dB absolute", "no noise"

/// Writes `folder`/`name`.md and, for each section, `folder`/`name`_SECTION.csv numbered from 1;
/// of one section `folder`/`name`.csv.
void write_study_tables(const Table& table, const std::filesystem::path& folder,
                        const std::string& name);

}  // namespace ertbench
