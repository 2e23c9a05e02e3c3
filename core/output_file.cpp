#include "core/output_file.h"

#include <system_error>

#include "core/errors.h"

namespace ertbench {

namespace fs = std::filesystem;

void require_output(const fs::path& output, const std::vector<fs::path>& inputs,
                    const OutputKind& kind) {
  std::error_code error;
  for (const fs::path& input : inputs) {
    if (fs::equivalent(input, output, error)) {
      throw InputError(output.string() + ": is the input " + input.string() +
                       "; name another output");
    }
  }
  if (!output.parent_path().empty() && !fs::is_directory(output.parent_path(), error)) {
    throw InputError(output.string() + ": there is no folder " + output.parent_path().string() +
                     "; make it first");
  }
  const fs::file_status status = fs::status(output, error);
  if (!fs::exists(status)) return;
  if (fs::is_directory(status)) {
    throw InputError(output.string() + ": is a directory; name a file in it");
  }
  if (!fs::is_regular_file(status) || !kind.is_one(output)) {
    throw InputError(output.string() + ": is there already and is no " + kind.name +
                     ", so that it is left alone; name another output, or remove it");
  }
}

}  // namespace ertbench
