#include "core/replace_file.h"

#include <unistd.h>

#include <string>
#include <system_error>

#include "core/errors.h"

namespace ertbench {

namespace fs = std::filesystem;

fs::path aside_of(const fs::path& file) {
  fs::path aside = file;
  return aside += "." + std::to_string(::getpid()) + ".part";
}

void put_in_place(const fs::path& aside, const fs::path& file) {
  std::error_code error;
  fs::rename(aside, file, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(aside, ignored);
  throw InputError(file.string() + ": cannot be put in place: " + error.message() +
                   "; check that its folder may be written and that no folder has its name");
}

}  // namespace ertbench
