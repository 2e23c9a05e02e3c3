#include "core/regular_file.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

const char* kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "a directory";
    case fs::file_type::fifo:
      return "a FIFO";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "a device";
    default:
      return "no regular file";
  }
}

}  // namespace

void require_regular_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::regular) return;
  if (status.type() == fs::file_type::not_found) {
    throw InputError(file.string() + ": cannot be opened: there is no such file; check the name");
  }
  if (status.type() == fs::file_type::none) {
    throw InputError(file.string() + ": cannot be opened: " + error.message() +
                     "; check the name and the permissions");
  }
  throw InputError(file.string() + ": is " + kind_of(status.type()) + "; name a regular file");
}

std::string contents_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace ertbench
