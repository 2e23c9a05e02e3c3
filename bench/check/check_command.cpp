
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/check/baseline.h"
#include "bench/check/check.h"
#include "bench/check/stored_images.h"
#include "bench/features/features.h"
#include "bench/record/record_file.h"
#include "bench/run/runner.h"
#include "bench/table/table.h"
#include "core/build.h"
#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* made_by = "ertbench check";

json mark_of(const std::string& program) { return {{"made_by", made_by}, {"program", program}}; }

/// The program in the mark of a check's folder; nothing without a mark.
std::optional<std::string> marked_program(const fs::path& mark) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(mark, error))) return std::nullopt;
  try {
    const json content = read_json_file(mark);
    JsonObject object(content, mark.string(), "");
    const std::string program = object.text("program");
    return content == mark_of(program) ? std::optional(program) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Makes `folder` the result folder of a check by `program` (a hash of it with its libraries and
/// plugins), with its own cache. Files of another build are removed: the cache's keys know the
/// experiment but not the code, so with another build's datasets, fits and records a check would
/// not see changes of the program. Files of this very program are kept, so that an interrupted
/// check resumes.
///
/// The folder is marked by `.ertbench-check`. Throws InputError, and removes nothing, if it holds
/// results without that mark.
Cache prepare_check_folder(const fs::path& folder, const std::string& program) {
  const fs::path mark = folder / ".ertbench-check";
  const fs::path made[] = {folder / "cache", folder / "records", folder / "seeds",
                           folder / "trainings", folder / "networks"};
  const std::optional<std::string> before = marked_program(mark);
  const auto is_there = [](const fs::path& one) { return fs::exists(fs::symlink_status(one)); };
  if (!before && std::any_of(std::begin(made), std::end(made), is_there)) {
    throw InputError(folder.string() +
                     ": holds results that are not a check's (there is no .ertbench-check in it); "
                     "name another folder with --out, remove this one, or take its results as they "
                     "are with --reuse");
  }
  if (before && *before != program) {
    for (const fs::path& one : made) fs::remove_all(one);
  }
  fs::create_directories(folder);
  write_file_atomically(mark, json_text(mark_of(program), 2) + "\n");
  return Cache(folder / "cache");
}

using Names = std::vector<std::string>;

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
    run(experiment_.check.seeds);
    std::vector<CheckLine> lines = compare(baseline, rows_, context());
    append(lines, compare_images("stored", networks(), baseline.networks));
    append(lines, compare_images("trained", trainings(), baseline.trainings));
    report(baseline, lines);
    return !has_regression(lines);
  }

  bool compare_images_alone() {
    const Baseline baseline = usable_baseline();
    open_cache();
    std::vector<CheckLine> lines = compare_images("stored", networks(), baseline.networks);
    append(lines, compare_images("trained", trainings(), baseline.trainings));
    std::printf("%s%s\n", terminal_of(check_table(lines, true)).c_str(),
                check_summary(lines).c_str());
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
    run(baseline_trainings());
    if (failures_ > 0) return refuse("a trial failed");
    const std::vector<StoredImages> fitted = networks();
    const std::vector<CheckLine> stored =
        compare_images("stored", fitted, before ? before->networks : Names());
    const std::vector<StoredImages> trained = trainings();
    Baseline baseline = make_baseline(experiment_, rows_, comparisons_of(experiment_, registry_));
    baseline.networks = distinct(fitted, &StoredImages::name);
    baseline.trainings = distinct(trained, &StoredImages::name);
    const std::vector<Noticeable> coarse = beyond_limits(noticeable(baseline));
    if (!coarse.empty() && !options_.accept_coarse) return refuse_coarse(coarse);
    const std::vector<CheckLine> changed_trainings =
        compare_images("trained", trained, baseline.trainings);
    if (!store_trainings(trained)) return refuse("a short training failed");
    if (file_.has_parent_path()) fs::create_directories(file_.parent_path());
    write_file_atomically(file_, to_json_text(baseline));
    std::vector<CheckLine> lines;
    if (before) {
      lines = compare(*before, rows_, context());
    } else {
      std::printf("Made anew: %s\n", printable(why, 1000).c_str());
    }
    append(lines, stored);
    append(lines, changed_trainings);
    std::printf("What changed beyond what was allowed:\n%s\n%s%s\n",
                terminal_of(check_table(lines, options_.all)).c_str(),
                terminal_of(noticeable_table(noticeable(baseline))).c_str(),
                weakest_text(noticeable(baseline)).c_str());
    std::printf("Baseline of %zu rows in %s\n", baseline.rows.size(),
                printable_path(file_.string()).c_str());
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

  void open_cache() {
    const auto program = [&] {
      return hash_of(to_json(stamp_of_this_build({}, experiment_.plugins)).dump());
    };
    cache_ = options_.reuse ? Cache::standard() : prepare_check_folder(run_.out, program());
  }

  /// Makes the rows; those of trained solvers over at least so many seeds.
  void run(int trainings) {
    open_cache();
    const ExperimentResults results = run_experiment(experiment_, *cache_, run_);
    report_experiment(experiment_, *cache_, results, run_.out);
    rows_ = read_summary_rows(run_.out);
    failures_ = results.failures;
    if (trainings > 0) {
      failures_ += train_over_seeds(experiment_, trained(), trainings, *cache_, run_, rows_);
    }
  }

  /// Labels of trained solvers, whose rows are compared by seeds.
  std::set<std::string> trained() const {
    std::set<std::string> labels;
    for (const auto& [label, images] : comparisons_of(experiment_, registry_)) {
      if (images == ImageComparison::seeds) labels.insert(label);
    }
    return labels;
  }

  int baseline_trainings() const {
    if (options_.seeds) return *options_.seeds;
    if (experiment_.check.baseline_seeds > 0) return experiment_.check.baseline_seeds;
    return trainings_of_entries() >= enough_seeds ? enough_seeds : usual_seeds;
  }

  /// The smallest number of seeds that an entry of a trained solver lists.
  int trainings_of_entries() const {
    const std::set<std::string> labels = trained();
    int fewest = usual_seeds;
    for (const std::span<const SolverEntry> row : experiment_.rows()) {
      if (labels.count(row.front().label) > 0) {
        fewest = std::min(fewest, static_cast<int>(row.size()));
      }
    }
    return fewest;
  }

  /// Number of trainings of each network in a check.
  int check_trainings() const { return std::max(experiment_.check.seeds, trainings_of_entries()); }

  std::vector<Noticeable> noticeable(const Baseline& baseline) const {
    return noticeable_worsenings(baseline, experiment_.sensor, check_trainings());
  }

  static void append(std::vector<CheckLine>& lines, const std::vector<CheckLine>& more) {
    lines.insert(lines.end(), more.begin(), more.end());
  }

  std::set<std::string> types() const {
    const std::vector<std::string> types = distinct(experiment_.solvers, &SolverEntry::type);
    return {types.begin(), types.end()};
  }

  /// The stored networks of the experiment's solvers, and of the type that is recommended for
  /// robots, which no experiment of a check trains.
  std::vector<StoredImages> networks() const {
    std::set<std::string> of_types = types();
    of_types.insert("lean-net");
    return stored_networks(file_.parent_path() / "networks", of_types, run_.out / "networks");
  }

  std::vector<StoredImages> trainings() const {
    return short_trainings(file_.parent_path() / "trainings", types(), *cache_,
                           run_.out / "trainings", run_.jobs);
  }

  CheckContext context() const {
    return {options_.warn_times ? "" : cpu_name(), experiment_.sensor};
  }

  void report(const Baseline& baseline, const std::vector<CheckLine>& lines) const {
    const auto machine = [](const json& provenance) {
      return "commit " + provenance.value("commit", "unknown") + ", " +
             provenance.value("date", "unknown") + ", " + provenance.value("cpu", "unknown");
    };
    const std::string old_machine =
        "old: " + printable_path(file_.string()) + ", " + machine(*baseline.provenance);
    const std::string new_machine = "new: " + machine(machine_provenance());
    const std::string weakest = weakest_text(noticeable(baseline));
    const std::string summary = check_summary(lines) + (weakest.empty() ? "" : "; " + weakest);
    const Table noticed = noticeable_table(noticeable(baseline));
    const std::string times =
        context().cpu == baseline.cpu ? ""
        : options_.warn_times
            ? "What is slower is only warned about.\n"
            : "The baseline was timed on another cpu: what is slower is only warned about.\n";
    write_file_atomically(run_.out / "check.md",
                          "# Check of " + experiment_.name + "\n\n" + summary + "\n\n- " +
                              old_machine + "\n- " + new_machine + "\n\n" + times +
                              (times.empty() ? "" : "\n") + markdown_of(check_report(lines)) +
                              "\n" + markdown_of(noticed));
    std::printf("\n%s\n%s\n%s\n%s\n%s%s; all of it in %s\n",
                terminal_of(check_table(lines, options_.all)).c_str(), terminal_of(noticed).c_str(),
                old_machine.c_str(), new_machine.c_str(), times.c_str(), summary.c_str(),
                printable_path((run_.out / "check.md").string()).c_str());
  }

  bool refuse_coarse(const std::vector<Noticeable>& coarse) const {
    const auto words = [](const Noticeable& one) {
      return one.row + " " + name_of(one.metric) + " only from " + text_of(one);
    };
    std::printf("A check would notice a worsening of %s.\n", joined(coarse, ", ", words).c_str());
    const int seeds = baseline_trainings();
    const auto enough = seeds_that_would_do(coarse, seeds, check_trainings(), most_seeds);
    if (enough) {
      std::printf("--seeds %d would do if more trainings scatter as these %d do, which are kept.\n",
                  *enough, seeds);
    }
    std::printf(
        "Raise /check/seeds or /check/baseline_seeds in %s, train longer, or accept it with "
        "--accept-coarse.\n",
        printable_path(experiment_.file.string()).c_str());
    return refuse("it would be too coarse");
  }

  bool refuse(const char* why) const {
    std::printf("%s, so that the baseline was left as it is: %s\n", why,
                printable_path(file_.string()).c_str());
    return false;
  }

  const Experiment& experiment_;
  SolverRegistry& registry_;
  const CheckOptions& options_;
  fs::path file_;
  RunOptions run_;
  std::optional<Cache> cache_;  ///< of this run
  std::vector<ResultRow> rows_;
  int failures_ = 0;
};

}  // namespace

bool check_experiment(const Experiment& experiment, SolverRegistry& registry,
                      const CheckOptions& options) {
  Check check(experiment, registry, options);
  if (options.images) return check.compare_images_alone();
  return options.update ? check.update() : check.compare_with_baseline();
}

}  // namespace ertbench
