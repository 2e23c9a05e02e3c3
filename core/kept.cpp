#include "core/kept.h"

#include <chrono>
#include <map>
#include <mutex>

#include "core/build.h"
#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds worth_keeping{333};

std::string program_ending() { return "-" + stamp_of_this_build().program; }

void put(const fs::path& file, const std::string& of_recipe,
         const std::function<void(const fs::path&)>& write) {
  fs::create_directories(file.parent_path());
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(file.parent_path())) {
    if (entry.path().filename().string().starts_with(of_recipe)) fs::remove(entry, ignored);
  }
  replace_file(file, write);
}

}  // namespace

fs::path kept_folder() { return cache_folder() / "kept"; }

bool is_kept_by_this_program(const fs::path& file) {
  return file.filename().string().ends_with(program_ending());
}

void keep(const std::string& name, const std::string& recipe,
          const std::function<void(const fs::path&)>& read, const std::function<void()>& compute,
          const std::function<void(const fs::path&)>& write) {
  const std::string of_recipe = name + "-" + hash_of(recipe);
  const fs::path file = kept_folder() / (of_recipe + program_ending());
  std::error_code absent;
  if (fs::exists(file, absent)) {
    try {
      return read(file);
    } catch (const InputError&) {  // damaged
    }
  }
  const auto start = std::chrono::steady_clock::now();
  compute();
  if (std::chrono::steady_clock::now() - start < worth_keeping) return;
  try {
    put(file, of_recipe, write);
  } catch (const std::exception&) {  // a full or read-only disk
  }
}

Eigen::MatrixXd kept_matrix(const std::string& name, const std::string& recipe,
                            const std::function<Eigen::MatrixXd()>& compute) {
  struct Last {
    std::string recipe;
    Eigen::MatrixXd matrix;
  };
  static std::mutex mutex;
  static std::map<std::string, Last> memory;
  const std::lock_guard lock(mutex);
  Last& last = memory[name];
  if (last.recipe == recipe) return last.matrix;
  last.recipe.clear();
  const auto read = [&](const fs::path& file) {
    const Hdf5File in = Hdf5File::open(file);
    if (const std::string why = in.why_changed(); !why.empty()) throw InputError(why);
    last.matrix = in.read_rows("/matrix", 0, in.shape("/matrix").front());
  };
  const auto write = [&](const fs::path& file) {
    Hdf5File out = Hdf5File::create(file);
    out.write_matrix("/matrix", last.matrix);
    out.write_checksum();
    out.close();
  };
  keep(
      name, recipe, read, [&] { last.matrix = compute(); }, write);
  last.recipe = recipe;
  return last.matrix;
}

}  // namespace ertbench
