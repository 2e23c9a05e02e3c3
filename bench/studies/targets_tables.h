#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/studies/targets.h"
#include "bench/table/table.h"

namespace ertbench {

/// A row for each number of contacts and solver.
TableSection targets_count_table(const TargetCircumstances& circumstances,
                                 const TargetResults& results);
/// A row for each solver: the resolvable gap, and the share told apart by gap.
TableSection targets_gap_table(const TargetCircumstances& circumstances,
                               const TargetResults& results);
/// How to read both.
std::vector<std::string> targets_notes(const TargetCircumstances& circumstances);

/// For programs, with all digits and intervals: solver, contacts, frames, scenes, metric, value,
/// ci_low, ci_high.
TableSection targets_count_data(const TargetResults& results);
/// The same of the gaps, a row for each bin and one for the resolvable gap.
TableSection targets_gap_data(const TargetResults& results);

/// NAME.md with the table as people read it, NAME.csv and NAME_gaps.csv with the data.
void write_targets_files(const TargetCircumstances& circumstances, const Table& table,
                         const TargetResults& results, const std::filesystem::path& folder);

}  // namespace ertbench
