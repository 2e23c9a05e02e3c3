#include "bench/check/check_folder.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/build.h"
#include "core/build_stamp.h"
#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::string program_hash(const std::vector<fs::path>& plugins) {
  return hash_of(to_json(stamp_of_this_build(this_build().record_code, plugins)).dump());
}

Cache prepare_check_folder(const fs::path& folder, const std::string& program) {
  const fs::path note = folder / "program";
  const fs::path made[] = {folder / "cache", folder / "records", folder / "seeds",
                           folder / "trainings"};
  if (!fs::exists(note)) {
    if (std::any_of(std::begin(made), std::end(made),
                    [](const auto& one) { return exists(one); })) {
      throw InputError(folder.string() +
                       ": holds results that are not a check's; name another folder with --out, or "
                       "take them as they are with --reuse");
    }
  } else if (bytes_of(note) != program) {
    for (const fs::path& one : made) fs::remove_all(one);
  }
  fs::create_directories(folder);
  write_file_atomically(note, program);
  return Cache(folder / "cache");
}

}  // namespace ertbench
