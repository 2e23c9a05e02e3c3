#pragma once

#include <filesystem>

#include "bench/table/table.h"

namespace ertbench {

/// What made each result in a folder of published ones, a row each in the order of their names:
/// the commits of the sources, the hashes of the code that scores and trainings depend on (Build;
/// where these are the same the numbers are of the same code, whatever the commit), when the last
/// of its numbers was measured and on which processor, and where and when its times were taken.
Table origins_table(const std::filesystem::path& published);

}  // namespace ertbench
