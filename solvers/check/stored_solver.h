#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ertbench {

/// Fitted solvers that come with the program: results/networks holds NAME.fitted and its card,
/// NAME.json, which says what it was trained on, its error, its time and where it fails.
std::vector<std::string> stored_solver_names();  ///< in order

/// NAME.fitted or, with the other ending, its card; there need not be one.
std::filesystem::path stored_solver_file(const std::string& name,
                                         const std::string& ending = ".fitted");

/// The value of "checkpoint": the file `word` in `folder`, else that of the stored solver of this
/// name. Throws InputError, which names the nearest stored solver, if there is neither.
std::filesystem::path fitted_file(const std::string& word, const std::filesystem::path& folder);

}  // namespace ertbench
