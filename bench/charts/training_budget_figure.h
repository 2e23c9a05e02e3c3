#pragma once

#include <filesystem>
#include <string>

#include "bench/analysis/training_budget.h"

namespace ertbench {

/// Draws `stem`.svg and `stem`.png: the error against the cost of the training (logarithmic), a
/// line with a dash and a mark of its own for each family, named at its end; a hollow mark where
/// the training had not converged. What has no point is named in the corner. Throws InputError
/// where gnuplot is missing or a file cannot be written.
void draw_training_budgets(const TrainingBudgets& budgets, const std::string& title,
                           const std::filesystem::path& stem);

}  // namespace ertbench
