#include "bench/run/fitted_solver.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/record/progress_file.h"
#include "core/atomic_file.h"
#include "core/file_lock.h"
#include "core/json_reader.h"
#include "core/replace_file.h"
#include "forward/data/dataset_file.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

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

}  // namespace

FittedSolver fitted_solver(const Experiment& experiment, const SolverEntry& entry,
                           const Cache& cache, SolverRegistry& registry, int threads,
                           const fs::path& progress_file) {
  const json spec = json::parse(entry.json);
  FittedSolver out;
  out.solver = registry.make(JsonObject(spec, experiment.file.string(), entry.path));
  const fs::path file = cache.fitted_solver(experiment, entry);
  fs::path note = file;
  note += ".json";
  const WorkFolder work_folder(cache.work_folder(experiment, entry));
  if (fs::exists(file) && fs::exists(note)) {
    try {
      out.fit_s = read_json_file(note).at("fit_s").get<double>();
      out.solver->load(file, experiment.sensor);
      return out;
    } catch (const std::exception&) {
      fs::remove(note);  // damaged: fit again
      out.solver = registry.make(JsonObject(spec, experiment.file.string(), entry.path));
    }
  }
  std::optional<DatasetFile> training;
  std::optional<DatasetFile> validation;
  FitInput input;
  input.sensor = experiment.sensor;
  input.threads = threads;
  input.work_folder = work_folder.path();
  if (experiment.training) input.training = &training.emplace(cache.dataset(*experiment.training));
  if (experiment.validation) {
    input.validation = &validation.emplace(cache.dataset(*experiment.validation));
  }
  const Clock::time_point start = Clock::now();
  {
    ProgressFile progress(progress_file);
    input.progress = [&](std::uint64_t done, std::uint64_t total, const std::string& text) {
      progress.update(done, total, text);
    };
    out.solver->fit(input);
  }
  out.fit_s = seconds_since(start) + out.solver->fit_report().earlier_s;
  replace_file(file, [&](const fs::path& aside) { out.solver->save(aside); });
  write_file_atomically(note,
                        json{{"fit_s", out.fit_s},
                             {"parameters", out.solver->parameters()},
                             {"key", json::parse(Cache::fitted_solver_key(experiment, entry))}}
                            .dump(2));
  return out;
}

}  // namespace ertbench
