#include "bench/run/datasets.h"

#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "bench/record/record_file.h"
#include "bench/run/timing_stage.h"
#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/seconds.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Why the file of a dataset is not to be taken as it is; empty where it may be. Reads all of it.
std::string why_not(const DatasetSpec& spec, const fs::path& file, Reuse reuse) {
  try {
    const DatasetFile set(file);
    if (set.recipe() != to_json(spec).dump()) return "it is another dataset than its name says";
    const std::string stale = why_stale(set.build(), stamp_of_dataset(spec), reuse);
    return stale.empty() ? set.why_changed() : stale;
  } catch (const InputError& error) {
    return std::string("it cannot be read: ") + error.what();
  }
}

/// The same, found out in a child: the HDF5 library does not survive every damaged file.
std::string why_not_safely(const DatasetSpec& spec, const fs::path& file, Reuse reuse) {
  const IsolatedOutcome outcome =
      run_isolated([&](const auto& send) { send(why_not(spec, file, reuse)); },
                   {600, machine_memory_bytes() / 2});
  if (outcome.finished && !outcome.messages.empty()) return outcome.messages.front();
  return "it is damaged: the HDF5 library cannot get through it (" + outcome.end.text() + ")";
}

/// Whether the cache has the dataset; what is not to be reused there is removed, and said.
bool is_there(const DatasetSpec& spec, const Cache& cache) {
  const fs::path file = cache.dataset(spec);
  if (!fs::exists(file)) return false;
  const std::string why = why_not_safely(spec, file, cache.reuse());
  if (why.empty()) return true;
  spdlog::info("dataset \"{}\" is made again: {}", spec.name, why);
  fs::remove(file);
  return false;
}

using Clock = SteadyClock;

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
      if (!note.at("fit_s").is_null()) out.fit_s = note.at("fit_s").get<double>();
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
  if (recipe.entry.spec->contains("checkpoint")) return;
  out.fit_s = seconds_since(start) + out.solver->fit_report().earlier_s;
}

/// `threads`: that it was fitted with; a training comes out otherwise with another number.
void save(const FitRecipe& recipe, const fs::path& file, const FittedSolver& fitted, int threads) {
  fs::path aside = file;
  aside += ".part";  // the lock on the work folder keeps others away
  replace_file(
      file, [&](const fs::path& place) { fitted.solver->save(place); }, aside);
  json note = {{"fit_s", fitted.fit_s ? json(*fitted.fit_s) : json()},
               {"build", to_json(*fitted.build)},
               {"parameters", fitted.solver->parameters()},
               {"threads", threads},
               {"key", Cache::fitted_solver_key(recipe)},
               {"file_checksum", hash_of_file(file)}};
  add_checksum(note);
  write_file_atomically(note_of(file), json_text(note, 2));
}

/// Warns of measured voltages in another unit than those of the set before.
void warn_of_other_units(const Experiment& experiment, const Cache& cache) {
  constexpr double most = 50;  // times: amplifiers of one sensor differ by less, mV and V by more
  const DatasetSpec* before = nullptr;
  double norm_before = 0;
  for (const DatasetSpec* spec : experiment.datasets()) {
    const double norm = cache.open_dataset(*spec).reference_voltages().norm();
    const double ratio = norm / norm_before;
    if (before && (spec->measured() || before->measured()) && (ratio > most || ratio * most < 1)) {
      spdlog::warn(
          "{}: reference voltages are {:.3g} times those of \"{}\"; if they are of another "
          "unit, give it with \"scale\"",
          spec->name, ratio, before->name);
    }
    before = spec;
    norm_before = norm;
  }
}

}  // namespace

void ensure_datasets(const Experiment& experiment, const Cache& cache) {
  const int cores = usable_cores();
  fs::create_directories(cache.folder() / "datasets");
  for (const DatasetSpec* spec : experiment.datasets()) {
    if (is_there(*spec, cache)) {
      warn_of_missed_promise(*spec, cache.dataset(*spec));
      continue;
    }
    Progress progress("generating \"" + spec->name + "\" (" + std::to_string(spec->count) +
                      " scenes, grid " + text_of(spec->model) + ")");
    generate_dataset(
        *spec, cache.dataset(*spec),
        {cores, [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); }});
    warn_of_missed_promise(*spec, cache.dataset(*spec));
  }
  warn_of_other_units(experiment, cache);
}

void warn_of_missed_promise(const DatasetSpec& spec, const fs::path& file) {
  const std::string missed = missed_promise(spec, DatasetFile(file)).sentence();
  if (!missed.empty()) spdlog::warn("{}: {}", spec.name, missed);
}

void ensure_dataset(const DatasetSpec& spec, const Cache& cache, int threads) {
  if (!is_there(spec, cache)) generate_dataset(spec, cache.dataset(spec), {threads, {}});
}

FittedSolver fitted_solver(const FitRecipe& recipe, const Cache& cache, SolverRegistry& registry,
                           int threads, const fs::path& progress_file) {
  const JsonObject spec(*recipe.entry.spec, recipe.source, recipe.entry.path);
  FittedSolver out;
  out.solver = registry.make(spec);
  const fs::path file = cache.fitted_solver(recipe);
  const WorkFolder work_folder(cache.work_folder(recipe));
  const BuildStamp now = stamp_of_fit(recipe);
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
