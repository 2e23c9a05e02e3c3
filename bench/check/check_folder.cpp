#include "bench/check/check_folder.h"

#include <link.h>

#include <algorithm>
#include <fstream>

#include "core/atomic_file.h"
#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The libraries of this process that are ours; not those of the system.
std::vector<fs::path> own_libraries() {
  std::vector<fs::path> out;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* found) {
        const fs::path library = info->dlpi_name;
        if (library.filename().string().starts_with("libertbench")) {
          static_cast<std::vector<fs::path>*>(found)->push_back(library);
        }
        return 0;
      },
      &out);
  return out;
}

}  // namespace

std::string program_hash(const std::vector<fs::path>& plugins) {
  std::vector<fs::path> files = own_libraries();
  files.insert(files.end(), plugins.begin(), plugins.end());
  std::sort(files.begin(), files.end());
  std::string hashes = hash_of(bytes_of("/proc/self/exe"));
  for (const fs::path& file : files) hashes += hash_of(bytes_of(file));
  return hash_of(hashes);
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
