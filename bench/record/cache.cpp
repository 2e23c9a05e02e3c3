#include "bench/record/cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/build.h"
#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/kept.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/check/stored_solver.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// The files among the words of a value, a string or a list of strings, in the order of the words.
/// Instead of a file a word may name a stored solver.
std::vector<std::filesystem::path> files_named(const nlohmann::json& value,
                                               const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  const nlohmann::json words = value.is_array() ? value : nlohmann::json::array({value});
  for (const nlohmann::json& word : words) {
    if (!word.is_string() || word.get_ref<const std::string&>().empty()) continue;
    std::filesystem::path file = folder / word.get<std::string>();
    std::error_code error;
    if (!std::filesystem::exists(file, error)) file = stored_solver_file(word.get<std::string>());
    if (std::filesystem::is_regular_file(file, error)) files.push_back(std::move(file));
  }
  return files;
}

/// Whether the name is one of the program's, "tsvd-HASH.fitted"; what else is there is not its own.
bool has_hash(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::string hash = stem.substr(stem.rfind('-') + 1);
  return hash.size() == 32 && hash.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::uint64_t bytes_of(const fs::path& file) {
  std::error_code gone;
  std::uint64_t sum = fs::is_directory(file, gone) ? 0 : fs::file_size(file, gone);
  if (gone) return 0;
  for (const auto& entry : fs::recursive_directory_iterator(file, gone)) {
    const std::uint64_t bytes = entry.is_regular_file(gone) ? entry.file_size(gone) : 0;
    if (!gone) sum += bytes;
  }
  return sum;
}

double age_days(const fs::path& file) {
  std::error_code gone;
  const auto age = fs::file_time_type::clock::now() - fs::last_write_time(file, gone);
  return gone ? 0 : std::chrono::duration<double, std::ratio<86400>>(age).count();
}

/// Whether a process holds the lock on the work folder of a fit.
bool is_locked(const fs::path& lock) {
  const int descriptor = ::open(lock.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0;
  ::close(descriptor);
  return locked;
}

void set_build(const std::optional<BuildStamp>& build, CachedThing& thing) {
  thing.commit = build ? build->commit_text() : "unknown";
  thing.stale = !build || !probe_difference(build->probes, current_probes(*build)).empty();
}

CachedThing cached_dataset(const fs::path& file) {
  CachedThing thing{"dataset", file, {file}};
  const fs::path epochs = fs::path(file).replace_extension(".epochs");
  if (fs::exists(epochs)) thing.files.push_back(epochs);
  std::optional<BuildStamp> build;
  try {
    build = DatasetFile(file).build();
  } catch (const InputError&) {
  }
  set_build(build, thing);
  return thing;
}

CachedThing cached_solver(const fs::path& file) {
  const fs::path note = fs::path(file) += ".json";
  const fs::path work = fs::path(file).replace_extension(".work");
  CachedThing thing{"solver", file, {file}};
  for (const fs::path& other : {note, work}) {
    if (fs::exists(other)) thing.files.push_back(other);
  }
  std::optional<BuildStamp> build;
  try {
    build = build_stamp_from_json(read_json_file(note).value("build", nlohmann::json()));
  } catch (const std::exception&) {
  }
  set_build(build, thing);
  thing.in_use = is_locked(work / "lock");
  return thing;
}

}  // namespace

Cache Cache::standard() { return Cache(cache_folder()); }

Cache::Cache(std::filesystem::path folder, Reuse reuse)
    : folder_(std::move(folder)), reuse_(reuse) {}

std::filesystem::path Cache::dataset(const DatasetSpec& spec) const {
  return folder_ / "datasets" / (spec.name + "-" + hash_of(to_json(spec).dump()) + ".h5");
}

DatasetFile Cache::open_dataset(const DatasetSpec& spec) const {
  DatasetFile set(dataset(spec));
  if (set.recipe() != to_json(spec).dump()) {
    throw InputError(set.path().string() +
                     ": holds another dataset than its name says; remove it and run again");
  }
  return set;
}

nlohmann::json Cache::fitted_solver_key(const FitRecipe& recipe) {
  nlohmann::json solver = *recipe.entry.spec;
  solver.erase("label");
  solver.erase("device");  // it changes a network by rounding alone, as the number of threads
  for (const std::string& name : recipe.entry.inference_parameters) solver.erase(name);
  nlohmann::json key = {{"format_version", solver_file_version},
                        {"solver", solver},
                        {"sensor", to_json(recipe.sensor)}};
  for (const std::filesystem::path& plugin : recipe.plugins) {
    key["plugins"].push_back(hash_of_file(plugin));
  }
  for (const std::string& name : recipe.entry.file_parameters) {
    for (const std::filesystem::path& file :
         files_named(solver.value(name, nlohmann::json()), folder_of_source(recipe.source))) {
      key["files"].push_back(hash_of_file(file));
    }
  }
  if (recipe.training) key["training"] = to_json(*recipe.training);
  if (recipe.validation) key["validation"] = to_json(*recipe.validation);
  return key;
}

std::filesystem::path Cache::fitted_solver(const FitRecipe& recipe) const {
  const std::string hash = hash_of(fitted_solver_key(recipe).dump());
  return folder_ / "solvers" / (recipe.entry.type + "-" + hash + ".fitted");
}

std::filesystem::path Cache::work_folder(const FitRecipe& recipe) const {
  return fitted_solver(recipe).replace_extension(".work");
}

CacheShare::CacheShare(const Cache& cache, Of of) {
  std::error_code unwritable;
  if (of == Of::run) fs::create_directories(cache.folder(), unwritable);
  const fs::path file = cache.folder() / ".in_use";
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (descriptor_ < 0) return;
  const int share = of == Of::run ? LOCK_SH : LOCK_EX | LOCK_NB;
  while (::flock(descriptor_, share) != 0) {
    if (errno == EINTR) continue;
    const bool taken = errno == EWOULDBLOCK;
    ::close(std::exchange(descriptor_, -1));
    if (!taken) return;
    throw InputError(printable_path(cache.folder().string()) +
                     ": a run needs what it holds; wait for its end, or add --dry-run");
  }
}

CacheShare::~CacheShare() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::vector<CachedThing> cache_contents(const Cache& cache) {
  std::vector<CachedThing> things;
  const auto add = [&](const char* folder, const char* ending, auto thing_at) {
    std::error_code absent;
    for (const auto& entry : fs::directory_iterator(cache.folder() / folder, absent)) {
      const bool ours = entry.path().extension() == ending && has_hash(entry.path());
      if (ours && entry.is_regular_file(absent)) things.push_back(thing_at(entry.path()));
    }
  };
  add("kept", "", [](const fs::path& file) {
    CachedThing thing{"kept", file, {file}};
    thing.stale = !is_kept_by_this_program(file);
    return thing;
  });
  add("datasets", ".h5", cached_dataset);
  add("solvers", ".fitted", cached_solver);
  for (CachedThing& thing : things) {
    thing.age_days = age_days(thing.file);
    for (const fs::path& file : thing.files) thing.bytes += bytes_of(file);
  }
  std::ranges::sort(things, [](const CachedThing& a, const CachedThing& b) {
    return std::pair(a.kind, a.file) < std::pair(b.kind, b.file);
  });
  return things;
}

void remove_cached(const CachedThing& thing) {
  // The note goes before the solver: without it the solver does not count.
  for (auto file = thing.files.rbegin(); file != thing.files.rend(); ++file) fs::remove_all(*file);
}

}  // namespace ertbench
