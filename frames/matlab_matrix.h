#pragma once

#include <filesystem>
#include <string>

#include "core/arrays.h"

namespace ertbench {

/// The numbers of a variable of a MATLAB file (versions 5 to 7), which may be NaN. Throws
/// InputError naming file and variable.
RowMajorMatrix read_matlab_matrix(const std::filesystem::path& file, const std::string& name);

}  // namespace ertbench
