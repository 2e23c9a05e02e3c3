#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/record/cache.h"

namespace ertbench {

/// A hash of this program with its own libraries that are loaded, and of `plugins`.
std::string program_hash(const std::vector<std::filesystem::path>& plugins);

/// Makes `folder` the result folder of a check, with a cache of its own in it. What another build
/// left there is removed, as the cache's keys know the experiment but not the code: with another's
/// datasets, fitted solvers and records a check would not see what changed in the program. What
/// this very program left is kept, so that an interrupted check goes on where it stopped.
///
/// The folder carries our mark, `.ertbench-check`; where it does not, nothing in it is removed.
/// Throws InputError where it holds results and no mark; they are left alone.
Cache prepare_check_folder(const std::filesystem::path& folder, const std::string& program);

}  // namespace ertbench
