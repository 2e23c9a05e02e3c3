#include "bench/publish/publish.h"

#include <algorithm>

#include "bench/features/features.h"
#include "bench/pages/page.h"
#include "bench/publish/latency_pairs.h"
#include "bench/publish/origins.h"
#include "bench/publish/published_folder.h"
#include "bench/publish/published_result.h"
#include "bench/record/limit_file.h"
#include "bench/run/runner.h"
#include "bench/speed/load_run.h"
#include "bench/table/table.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// What git prints, in the parts between the separators. Throws InputError where it fails.
std::vector<std::string> git(const fs::path& project, const std::vector<std::string>& arguments,
                             std::string_view separator = "\n") {
  const TemporaryFolder folder;
  std::vector<std::string> command = {"git", "-C", project.string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const fs::path output = folder.path() / "output";
  ChildProcess process(command, {folder.path() / "log", output}, {60});
  if (!process.wait().ok()) {
    throw InputError(project.string() + ": publishing needs the project's git repository: " +
                     one_line(contents_of(folder.path() / "log"), 200));
  }
  std::vector<std::string> parts = split(contents_of(output), separator);
  std::erase(parts, "");
  return parts;
}

/// Whether publishing itself writes the file, so that its change is no matter.
bool is_published(const fs::path& project, const fs::path& file) {
  if (file.string().starts_with("results/published/")) return !file.string().ends_with(".md.in");
  for (const fs::path& page_template : page_templates(project)) {
    if (fs::relative(page_of(page_template), project) == file) return true;
  }
  return false;
}

/// Where a figure could not be drawn, its .svg says why and there is no .png (draw_or_say): then
/// `made`, which was to be published as `published`, is removed, and InputError thrown.
void require_drawn(const fs::path& made, const fs::path& published) {
  for (const auto& entry : fs::recursive_directory_iterator(made)) {
    const fs::path& figure = entry.path();
    if (figure.extension() != ".svg") continue;
    if (fs::exists(fs::path(figure).replace_extension(".png"))) continue;
    const std::string name = fs::relative(figure, made).string();
    fs::remove_all(made);
    throw InputError(published.string() + ": " + name +
                     " could not be drawn, as said above; what was published before is as it was");
  }
}

/// Copies what `ertbench limit` left beside the results where their rows are of it.
void publish_limits(const ExperimentResults& results, const fs::path& from, const fs::path& to) {
  if (std::none_of(results.rows.begin(), results.rows.end(), is_limit)) return;
  for (const char* name : {limit_file, "limit_ranks.png", "limit_ranks.svg"}) {
    if (fs::exists(from / name)) fs::copy_file(from / name, to / name);
  }
}

Stages stages_of(const Experiment& experiment, Publishing what) {
  if (what == Publishing::models) return stages_of_fidelity(fidelity_usual_scenes);
  Stages stages = stages_of_run(experiment);
  if (what == Publishing::scores) {
    std::erase_if(stages, [](const auto& stage) { return stage->wants_machine_alone(); });
  }
  return stages;
}

/// Of trainings on another machine the cache has no logs. They stand beside their records, where
/// an earlier report of this result folder has put them.
void find_training_logs(const fs::path& folder, ExperimentResults& results) {
  for (auto& [label, sources] : results.training) {
    for (TrainingSource& source : sources) {
      if (!fs::exists(source.log)) source.log = folder / (source.stem + ".csv");
    }
  }
}

}  // namespace

void require_committed(const fs::path& project) {
  std::vector<std::string> changes;
  // Names as they are: without -z git puts those with blanks in quotes.
  const std::vector<std::string> status =
      git(project, {"status", "--porcelain", "-z", "--no-renames", "-uall"}, {"\0", 1});
  for (const std::string& one : status) {
    const std::string file = one.substr(std::min<std::size_t>(3, one.size()));
    if (!is_published(project, file)) changes.push_back(file);
  }
  if (!changes.empty()) {
    throw InputError(
        project.string() + ": " + changes.front() +
        (changes.size() > 1 ? " and " + std::to_string(changes.size() - 1) + " more" : "") +
        " differ from the last commit; commit or remove them, so that what is "
        "published can be made again");
  }
  std::vector<std::string> arguments = {"log", "-1", "--format=%H", "--"};
  for (const std::string& one : split(this_build().sources, " ")) arguments.push_back(one);
  const std::vector<std::string> commit = git(project, arguments);
  if (this_build().dirty || commit.empty() || !commit.front().starts_with(this_build().commit)) {
    throw InputError(
        "this program was built of commit " + commit_text(this_build().commit, this_build().dirty) +
        ", the tree's sources are of " + (commit.empty() ? "none" : commit.front().substr(0, 12)) +
        "; build it again, ./ertbench does");
  }
}

int publish_experiment(const Experiment& experiment, const fs::path& project, const Cache& cache,
                       int jobs, Publishing what) {
  const fs::path published = project / "results/published" / experiment.name;
  std::optional<PublishedResult> timed;
  if (what == Publishing::scores) timed = read_published(experiment, published);
  const Stages stages = stages_of(experiment, what);
  RunOptions run;
  run.out = project / "results" / experiment.name;
  run.jobs = jobs;
  ExperimentResults results = run_stages(stages, experiment, cache, run);
  find_training_logs(run.out / "training", results);
  if (timed) take_times(*timed, experiment, results.rows);
  const fs::path made = part_of(published);
  if (what == Publishing::models) {
    report_stages(stages, experiment, results, made);
  } else {
    report_experiment(experiment, cache, results, made);
  }
  if (timed) write_clocks(*timed, experiment, results.rows, made);
  require_drawn(made, published);
  publish_limits(results, run.out, made);
  replace_folder(published, made);
  return results.failures;
}

void require_undisturbed(const LoadResults& results, const fs::path& published) {
  const auto busy = std::find_if(results.solvers.begin(), results.solvers.end(),
                                 [](const SolverLoad& solver) { return solver.busy(); });
  if (busy == results.solvers.end()) return;
  throw InputError(published.string() + ": \"" + busy->label + "\" lost " +
                   fixed(100 * busy->lost_share, 0) +
                   " % of its time to other work of the machine, so that its rates are too low; "
                   "leave the machine to it and publish again. What was published before is as it "
                   "was");
}

int publish_load(const Experiment& experiment, SolverRegistry& registry, const fs::path& project,
                 const Cache& cache) {
  const LoadResults results = run_load(experiment, cache, registry, {});
  const fs::path published = project / "results/published" / experiment.name;
  require_undisturbed(results, published);
  const fs::path made = part_of(published);
  write_load(results, made);
  require_drawn(made, published);
  replace_folder(published, made);
  return static_cast<int>(
      std::count_if(results.solvers.begin(), results.solvers.end(),
                    [](const SolverLoad& solver) { return !solver.failure.empty(); }));
}

std::vector<std::pair<fs::path, std::string>> rendered_pages(const fs::path& project) {
  std::vector<std::pair<fs::path, std::string>> out;
  const fs::path results = project / "results/published";
  for (const fs::path& page_template : page_templates(project)) {
    out.emplace_back(page_of(page_template),
                     render_page(contents_of(page_template),
                                 fs::relative(page_template, project).string(), results));
  }
  out.emplace_back(results / "latencies.md",
                   markdown_of(latency_table(latency_pairs(timed_solvers(results)))));
  out.emplace_back(results / "builds.md", markdown_of(origins_table(results)));
  return out;
}

void publish_pages(const fs::path& project) {
  for (const fs::path& source : page_sources(project)) {
    const std::vector<std::string> numbers = literal_numbers(contents_of(source));
    if (numbers.empty()) continue;
    throw InputError(source.string() + ": " + numbers.front() +
                     ": a number typed by hand; refer to a result, or declare it among the page's "
                     "constants (bench/pages/page.h)");
  }
  for (const auto& [page, text] : rendered_pages(project)) write_file_atomically(page, text);
}

}  // namespace ertbench
