#include "core/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <system_error>

#include "core/errors.h"

namespace ertbench {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(const std::string& name) {
  std::string path = (fs::temp_directory_path() / ("ertbench_" + name + "_XXXXXX")).string();
  if (::mkdtemp(path.data()) == nullptr) {
    throw InputError(path + ": no temporary folder (" + std::generic_category().message(errno) +
                     "); set TMPDIR to a folder that may be written");
  }
  path_ = path;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace ertbench
