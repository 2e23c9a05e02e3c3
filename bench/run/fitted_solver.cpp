#include "bench/run/fitted_solver.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/record/progress_file.h"
#include "core/atomic_file.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/file_lock.h"
#include "core/json_checksum.h"
#include "core/json_reader.h"
#include "core/json_text.h"
#include "core/replace_file.h"
#include "core/seconds.h"
#include "forward/data/dataset_file.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using Clock = SteadyClock;
using nlohmann::json;

/// The work folder of a fit, for one process at a time: another that fits the same solver is waited
/// for. Goes with the lock unless the solver left something in it.
class WorkFolder {
 public:
  explicit WorkFolder(fs::path path) : path_(std::move(path)), lock_(file(), MissingFolder::make) {}
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove(file(), ignored);
    fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path file() const { return path_ / "lock"; }

  fs::path path_;
  FileLock lock_;
};

/// The note that stands beside a fitted solver.
fs::path note_of(fs::path file) { return file += ".json"; }

BuildStamp stamp_of_fit(const FitRecipe& recipe, const SolverRegistry& registry) {
  return stamp_of_this_build(this_build().fit_codes.at(registry.room_of(recipe.entry.type)),
                             recipe.plugins);
}

/// Whether the cache had the solver and it may be reused; what is damaged there is forgotten.
/// `now`: the stamp that it would be given if it were made now.
bool load(const FitRecipe& recipe, const BuildStamp& now, const fs::path& file, Reuse reuse,
          FittedSolver& out) {
  if (!fs::exists(file) || !fs::exists(note_of(file))) return false;
  std::string why;
  try {
    json note = read_json_file(note_of(file));
    why = take_checksum(note);
    out.build = build_stamp_from_json(note.value("build", json()));
    if (why.empty()) why = why_stale(out.build, now, reuse);
    if (why.empty() && note.at("key") != Cache::fitted_solver_key(recipe)) {
      why = "it is another solver than its name says";
    }
    if (why.empty() && note.at("file_checksum") != hash_of_file(file)) {
      why = "its file has been changed since it was written";
    }
    if (why.empty()) {
      out.fit_s = note.at("fit_s").get<double>();
      out.solver->load(file, recipe.sensor);
      return true;
    }
  } catch (const FailedTrial&) {  // the solver's own program; the file is as it was
    throw;
  } catch (const std::exception& error) {
    why = std::string("it cannot be read: ") + error.what();
  }
  spdlog::warn("{}: the fitted solver is made again: {}", file.string(), why);
  fs::remove(note_of(file));
  return false;
}

void fit(const FitRecipe& recipe, const Cache& cache, const fs::path& work_folder, int threads,
         const fs::path& progress_file, FittedSolver& out) {
  std::optional<DatasetFile> training;
  std::optional<DatasetFile> validation;
  FitInput input;
  input.sensor = recipe.sensor;
  input.threads = threads;
  input.work_folder = work_folder;
  if (recipe.training) input.training = &training.emplace(cache.open_dataset(*recipe.training));
  if (recipe.validation)
    input.validation = &validation.emplace(cache.open_dataset(*recipe.validation));
  const Clock::time_point start = Clock::now();
  ProgressFile progress(progress_file);
  input.progress = [&](std::uint64_t done, std::uint64_t total, const std::string& text) {
    progress.update(done, total, text);
  };
  out.solver->fit(input);
  out.fit_s = seconds_since(start) + out.solver->fit_report().earlier_s;
}

/// `threads`: that it was fitted with; a training comes out otherwise with another number.
void save(const FitRecipe& recipe, const fs::path& file, const FittedSolver& fitted, int threads) {
  fs::path aside = file;
  aside += ".part";  // the lock on the work folder keeps others away
  replace_file(
      file, [&](const fs::path& place) { fitted.solver->save(place); }, aside);
  json note = {{"fit_s", fitted.fit_s},
               {"build", to_json(*fitted.build)},
               {"parameters", fitted.solver->parameters()},
               {"threads", threads},
               {"key", Cache::fitted_solver_key(recipe)},
               {"file_checksum", hash_of_file(file)}};
  add_checksum(note);
  write_file_atomically(note_of(file), json_text(note, 2));
}

}  // namespace

FittedSolver fitted_solver(const FitRecipe& recipe, const Cache& cache, SolverRegistry& registry,
                           int threads, const fs::path& progress_file) {
  const JsonObject spec(*recipe.entry.spec, recipe.source, recipe.entry.path);
  FittedSolver out;
  out.solver = registry.make(spec);
  const fs::path file = cache.fitted_solver(recipe);
  const WorkFolder work_folder(cache.work_folder(recipe));
  const BuildStamp now = stamp_of_fit(recipe, registry);
  if (load(recipe, now, file, cache.reuse(), out)) return out;
  out.solver = registry.make(spec);  // a damaged file may have left it half loaded
  fit(recipe, cache, work_folder.path(), threads, progress_file, out);
  out.build = now;
  save(recipe, file, out, threads);
  return out;
}

void forget_fitted_solver(const FitRecipe& recipe, const Cache& cache) {
  const fs::path file = cache.fitted_solver(recipe);
  fs::remove(note_of(file));
  fs::remove(file);
  fs::remove_all(cache.work_folder(recipe));
}

}  // namespace ertbench
