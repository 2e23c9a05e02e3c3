#include "core/build_stamp.h"

#include <link.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/build.h"
#include "core/checksum.h"
#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr const char* learned_solvers = "libertbench_models.so";

/// The program's own libraries. Parts (bench/features/parts.h) are left out, and the learned
/// solvers are always in: the list must not depend on what this process has loaded so far.
std::vector<fs::path> own_libraries() {
  std::vector<fs::path> out;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* found) {
        const fs::path library = info->dlpi_name;
        const std::string name = library.filename().string();
        for (const char* own : {"core", "forward", "solvers", "bench"}) {
          if (name == "libertbench_" + std::string(own) + ".so") {
            static_cast<std::vector<fs::path>*>(found)->push_back(library);
          }
        }
        return 0;
      },
      &out);
  std::error_code ignored;
  const fs::path learned =
      fs::read_symlink("/proc/self/exe", ignored).parent_path() / learned_solvers;
  if (fs::exists(learned, ignored)) out.push_back(learned);
  std::sort(out.begin(), out.end(),
            [](const fs::path& a, const fs::path& b) { return a.filename() < b.filename(); });
  return out;
}

std::string program_hash() {
  std::string hashes = hash_of_file("/proc/self/exe");
  for (const fs::path& library : own_libraries()) hashes += hash_of_file(library);
  return hash_of(hashes);
}

}  // namespace

std::string hash_of(const std::string& text) {
  Checksum checksum;
  checksum.add(text);
  return checksum.text();
}

std::string hash_of_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const auto require = [&](bool readable) {
    if (!readable) {
      throw InputError(file.string() + ": cannot be read; check that it is there and may be read");
    }
  };
  require(in.is_open());
  Checksum checksum;
  std::string bytes(std::size_t{1} << 20, '\0');
  while (in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())) || in.gcount() > 0) {
    checksum.add({bytes.data(), static_cast<std::size_t>(in.gcount())});
  }
  require(!in.bad());
  return checksum.text();
}

std::string BuildStamp::commit_text() const { return ertbench::commit_text(commit, dirty); }

bool BuildStamp::operator==(const BuildStamp& other) const {
  return commit == other.commit && dirty == other.dirty && program == other.program &&
         plugins == other.plugins &&
         std::equal(probes.begin(), probes.end(), other.probes.begin(), other.probes.end(),
                    [](const auto& a, const auto& b) {
                      return a.first == b.first && a.second.numbers == b.second.numbers;
                    });
}

BuildStamp stamp_of_this_build(Probes probes, std::span<const fs::path> plugins) {
  static const std::string program = program_hash();
  BuildStamp stamp{this_build().commit, this_build().dirty, program, std::move(probes), {}};
  for (const fs::path& plugin : plugins) stamp.plugins.push_back(hash_of_file(plugin));
  return stamp;
}

nlohmann::json to_json(const BuildStamp& stamp) {
  nlohmann::json out = {
      {"commit", stamp.commit}, {"dirty", stamp.dirty}, {"program", stamp.program}};
  if (!stamp.probes.empty()) out["probes"] = to_json(stamp.probes);
  if (!stamp.plugins.empty()) out["plugins"] = stamp.plugins;
  return out;
}

std::optional<BuildStamp> build_stamp_from_json(const nlohmann::json& stamp) {
  try {
    BuildStamp out{stamp.at("commit"), stamp.at("dirty"), stamp.at("program"), {}, {}};
    if (stamp.contains("probes")) out.probes = probes_from_json(stamp.at("probes"));
    if (stamp.contains("plugins")) out.plugins = stamp.at("plugins");
    return out;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace ertbench
