#pragma once

#include <filesystem>

namespace ertbench {

/// The commit that the program was built from, with "-dirty" where files had changed.
const char* build_commit();
/// The folder of the sources that the program was built from.
std::filesystem::path project_folder();

}  // namespace ertbench
