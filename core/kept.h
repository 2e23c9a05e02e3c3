#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>

namespace ertbench {

/// The folder of the cache for what commands computed beside experiments, in files NAME-RECIPE-
/// PROGRAM, the last two hashes.
std::filesystem::path kept_folder();
/// Whether this program kept a file of that folder; no other program reads it.
bool is_kept_by_this_program(const std::filesystem::path& file);

/// Calls `read` with the file of what follows from `recipe` and this program alone, or `compute`
/// where there is none or `read` throws InputError, and then, if that took a third of a second or
/// longer, `write` with its name; files of other programs of this recipe go. A file that cannot be
/// written is done without.
void keep(const std::string& name, const std::string& recipe,
          const std::function<void(const std::filesystem::path&)>& read,
          const std::function<void()>& compute,
          const std::function<void(const std::filesystem::path&)>& write);

/// A matrix so, which also stays in memory until the next one of that name.
Eigen::MatrixXd kept_matrix(const std::string& name, const std::string& recipe,
                            const std::function<Eigen::MatrixXd()>& compute);

}  // namespace ertbench
