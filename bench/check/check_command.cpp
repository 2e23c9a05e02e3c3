#include "bench/check/check_command.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/check/baseline.h"
#include "bench/check/check.h"
#include "bench/check/check_folder.h"
#include "bench/check/check_networks.h"
#include "bench/check/check_seeds.h"
#include "bench/check/check_table.h"
#include "bench/record/provenance.h"
#include "bench/run/runner.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/build.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Check {
 public:
  Check(const Experiment& experiment, SolverRegistry& registry, const CheckOptions& options)
      : experiment_(experiment), registry_(registry), options_(options), file_(options.baseline) {
    if (file_.empty()) {
      file_ = project_folder() / "results/baselines" / (experiment.name + ".json");
    }
    run_.out = options.out;
    run_.jobs = options.jobs;
    if (run_.out.empty()) {
      run_.out = fs::path("results") / experiment.name / (options.reuse ? "" : "check");
    }
  }

  bool compare_with_baseline() {
    const Baseline baseline = usable_baseline();
    run();
    std::vector<CheckLine> lines = compare(baseline, rows_, context());
    const std::vector<CheckLine> stored = stored_networks();
    lines.insert(lines.end(), stored.begin(), stored.end());
    report(baseline, lines);
    return !has_regression(lines);
  }

  bool update() {
    std::optional<Baseline> before;
    std::string why = "there was none";
    try {
      before = usable_baseline();
    } catch (const InputError& error) {
      if (fs::exists(file_)) why = error.what();
    }
    const Cache cache = run();
    if (failures_ > 0) return refuse("a trial failed");
    const Comparisons comparisons = comparisons_of(experiment_, registry_);
    const auto spread = spread_of(trained_labels(comparisons), cache);
    if (!spread) return refuse("a training failed");
    const std::vector<CheckLine> stored = stored_networks();
    const Baseline baseline = make_baseline(experiment_, rows_, comparisons, *spread);
    if (file_.has_parent_path()) fs::create_directories(file_.parent_path());
    write_file_atomically(file_, to_json_text(baseline));
    std::vector<CheckLine> lines = stored;
    if (before) {
      lines = compare(*before, rows_, context());
      lines.insert(lines.end(), stored.begin(), stored.end());
    } else {
      std::printf("Made anew: %s\n", why.c_str());
    }
    std::printf("What changed beyond what was allowed:\n%s",
                terminal_of(check_table(lines, options_.all)).c_str());
    std::printf("Baseline of %zu rows in %s\n", baseline.rows.size(), file_.c_str());
    return !has_regression(stored);
  }

 private:
  std::string update_command() const {
    return "`ertbench check " + experiment_.file.string() + " --update`";
  }

  Baseline usable_baseline() const {
    if (!fs::exists(file_)) {
      throw InputError(file_.string() + ": there is no baseline to compare with; make it with " +
                       update_command());
    }
    try {
      Baseline baseline = read_baseline(file_);
      const std::string change = changed_experiment(baseline, experiment_);
      if (change.empty()) return baseline;
      throw InputError(file_.string() + ": was made of another experiment: " + change + " in " +
                       experiment_.file.string());
    } catch (const InputError& error) {
      throw InputError(std::string(error.what()) + "; make the baseline anew with " +
                       update_command());
    }
  }

  Cache run() {
    Cache cache = options_.reuse
                      ? Cache::standard()
                      : prepare_check_folder(run_.out, program_hash(experiment_.plugins));
    const ExperimentResults results = run_experiment(experiment_, cache, run_);
    report_experiment(experiment_, cache, results, run_.out);
    failures_ = results.failures;
    rows_ = read_summary_rows(run_.out);
    return cache;
  }

  /// Of each trained label rows over enough seeds.
  std::optional<std::vector<ResultRow>> spread_of(const std::set<std::string>& trained,
                                                  const Cache& cache) {
    std::vector<ResultRow> spread;
    std::set<std::string> more = trained;
    const int enough = options_.seeds.value_or(enough_seeds);
    for (const ResultRow& row : rows_) {
      if (!row.seeds || std::ssize(row.seeds->values) < enough) continue;
      spread.push_back(row);
      more.erase(row.label);
    }
    if (more.empty()) return spread;
    const auto rows =
        rows_over_seeds(experiment_, more, options_.seeds.value_or(usual_seeds), cache, run_);
    if (!rows) return std::nullopt;
    spread.insert(spread.end(), rows->begin(), rows->end());
    return spread;
  }

  std::vector<CheckLine> stored_networks() const {
    std::set<std::string> types;
    for (const SolverEntry& entry : experiment_.solvers) types.insert(entry.type);
    return compare_stored_networks(file_.parent_path() / "networks", types, run_.out / "networks");
  }

  CheckContext context() const {
    return {options_.warn_times ? "" : cpu_name(), experiment_.sensor};
  }

  void report(const Baseline& baseline, const std::vector<CheckLine>& lines) const {
    const auto machine = [](const json& provenance) {
      return "commit " + provenance.value("commit", "unknown") + ", " +
             provenance.value("date", "unknown") + ", " + provenance.value("cpu", "unknown");
    };
    const std::string old_machine = "old: " + file_.string() + ", " + machine(*baseline.provenance);
    const std::string new_machine = "new: " + machine(machine_provenance());
    const std::string summary = check_summary(lines);
    const std::string times =
        context().cpu == baseline.cpu ? ""
        : options_.warn_times
            ? "What is slower is only warned about.\n"
            : "The baseline was timed on another cpu: what is slower is only warned about.\n";
    write_file_atomically(run_.out / "check.md",
                          "# Check of " + experiment_.name + "\n\n" + summary + "\n\n- " +
                              old_machine + "\n- " + new_machine + "\n\n" + times +
                              (times.empty() ? "" : "\n") + markdown_of(check_report(lines)));
    std::printf("\n%s\n%s\n%s\n%s%s; all of it in %s\n",
                terminal_of(check_table(lines, options_.all)).c_str(), old_machine.c_str(),
                new_machine.c_str(), times.c_str(), summary.c_str(),
                (run_.out / "check.md").c_str());
  }

  bool refuse(const char* why) const {
    std::printf("%s, so that the baseline was left as it is: %s\n", why, file_.c_str());
    return false;
  }

  const Experiment& experiment_;
  SolverRegistry& registry_;
  const CheckOptions& options_;
  fs::path file_;
  RunOptions run_;
  std::vector<ResultRow> rows_;
  int failures_ = 0;
};

}  // namespace

bool check_experiment(const Experiment& experiment, SolverRegistry& registry,
                      const CheckOptions& options) {
  Check check(experiment, registry, options);
  return options.update ? check.update() : check.compare_with_baseline();
}

}  // namespace ertbench
