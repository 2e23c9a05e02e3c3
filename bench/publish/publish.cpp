#include "bench/publish/publish.h"

#include <fcntl.h>
#include <stdio.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <system_error>

#include "bench/features/features.h"
#include "bench/pages/page.h"
#include "bench/record/limit_file.h"
#include "bench/run/results.h"
#include "bench/run/runner.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The picture that `ertbench limit` draws beside its file.
constexpr const char* limit_ranks = "limit_ranks.png";

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

/// Whether publishing itself writes the file, so that its change does not count.
bool is_published(const fs::path& project, const fs::path& file) {
  if (file.string().starts_with("results/published/")) return !file.string().ends_with(".md.in");
  for (const fs::path& page_template : page_templates(project)) {
    if (fs::relative(page_of(page_template), project) == file) return true;
  }
  return false;
}

/// The folder beside `published` in which it is made; what an interrupted call left there is gone.
fs::path empty_part_of(const fs::path& published) {
  const fs::path part = published.string() + ".part";
  fs::remove_all(part);
  fs::create_directories(part);
  return part;
}

/// Removes `made` where one of its figures was not drawn: then its .svg gives the reason, and there
/// is no .png (draw_or_say).
void require_drawn(const fs::path& made, const fs::path& published) {
  for (const auto& entry : fs::recursive_directory_iterator(made)) {
    if (entry.path().extension() != ".svg") continue;
    if (fs::exists(fs::path(entry.path()).replace_extension(".png"))) continue;
    const std::string name = fs::relative(entry.path(), made).string();
    fs::remove_all(made);
    throw InputError(published.string() + ": " + name +
                     " could not be drawn, as said above; what was published before is as it was");
  }
}

/// Published limits take hours to compute: those that the folder of results lacks are put there,
/// and the run leaves them out where their sets or their probes are others. Whether there are any.
bool bring_limits(const fs::path& published, const fs::path& folder) {
  if (!fs::exists(published / "summary.json")) return false;
  const std::vector<ResultRow> there = read_limit_rows(folder);
  json limits = {{"rows", json::array()}, {"sets", json::array()}};
  if (!there.empty()) limits = read_json_file(folder / limit_file);
  bool any = false;
  const json before = read_json_file(published / "summary.json");
  for (const json& row : before.value("rows", json::array())) {
    if (!row.value("type", "").starts_with("limit-")) continue;
    any = true;
    const bool computed = std::ranges::any_of(there, [&](const ResultRow& one) {
      return one.type == row.at("type") && one.dataset == row.at("dataset");
    });
    if (!computed) limits["rows"].push_back(row);
  }
  if (!any) return false;
  fs::create_directories(folder);
  write_file_atomically(folder / limit_file, limits.dump(1) + "\n");
  if (fs::exists(published / limit_ranks)) {
    fs::copy_file(published / limit_ranks, folder / limit_ranks, fs::copy_options::skip_existing);
  }
  return true;
}

/// The text of every page and template, in which the published files that readers need are named:
/// those in results/published/NAME itself, and those of the rest of the project.
struct PageTexts {
  std::string own;
  std::string others;

  PageTexts(const fs::path& project, const fs::path& published) {
    std::vector<fs::path> pages = page_templates(project);
    for (const auto& entry : fs::directory_iterator(project / "docs")) {
      if (entry.path().extension() == ".md") pages.push_back(entry.path());
    }
    for (const fs::path& page : pages) {
      (page.parent_path() == published ? own : others) += contents_of(page);
    }
  }

  bool name(const std::string& result, const std::string& file) const {
    return holds(others, result + "/" + file) || holds(own, file);
  }

 private:
  /// Whether the text has the name, and not only as the end of a longer one.
  static bool holds(const std::string& text, const std::string& name) {
    for (auto at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
      const auto before = static_cast<unsigned char>(at > 0 ? text[at - 1] : ' ');
      if (!std::isalnum(before) && before != '_' && before != '-') return true;
    }
    return false;
  }
};

/// Removes the lists by position and by candidate, of which no page shows a value, and all digits
/// behind the seventh.
void drop_details(json& value) {
  if (value.is_number_float()) {
    value = std::strtod(with_digits(value.get<double>(), 7).c_str(), nullptr);
    return;
  }
  if (value.is_object()) {
    for (const char* key : {"places", "by_place"}) {
      if (value.contains(key) && value.at(key).is_array()) value.erase(key);
    }
  }
  for (json& child : value) {
    if (child.is_structured() || child.is_number_float()) drop_details(child);
  }
}

/// Writes the summary again without what no page shows and without indentation.
void shorten_summary(const fs::path& file) {
  if (!fs::exists(file)) return;
  json summary = read_json_file(file);
  drop_details(summary);
  write_file_atomically(file, json_text(summary) + "\n");
}

/// Gives a picture a palette, of the most colours with which its file is small enough.
void shrink_picture(const fs::path& picture) {
  const TemporaryFolder folder;
  const fs::path smaller = folder.path() / "smaller.png";
  for (const char* colours : {"128", "64", "32"}) {
    ChildProcess pngquant({"pngquant", "--force", "--strip", "--nofs", "--output", smaller.string(),
                           colours, "--", picture.string()},
                          {folder.path() / "log"}, {60});
    if (!pngquant.wait().ok()) {
      throw InputError(picture.string() +
                       ": pngquant, which Debian's package of that name has, could not give it a "
                       "palette: " +
                       one_line(contents_of(folder.path() / "log"), 200));
    }
    if (fs::file_size(smaller) <= most_picture_bytes) {
      return write_file_atomically(picture, contents_of(smaller));
    }
  }
  throw InputError(picture.string() + ": it has more than " +
                   std::to_string(most_picture_bytes / 1000) +
                   " kB even with 32 colours; draw it smaller, or name it on no page");
}

/// Puts `made` in the place of `published` in one step, with the templates of pages that stand
/// there and their pages.
void replace_folder(const fs::path& published, const fs::path& made) {
  if (!fs::exists(published)) {
    fs::rename(made, published);
    return;
  }
  for (const auto& entry : fs::directory_iterator(published)) {
    if (!entry.path().string().ends_with(".md.in")) continue;
    const auto skip = fs::copy_options::skip_existing;
    fs::copy_file(entry.path(), made / entry.path().filename(), skip);
    const fs::path page = page_of(entry.path());
    if (fs::exists(page)) fs::copy_file(page, made / page.filename(), skip);
  }
  if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, published.c_str(), RENAME_EXCHANGE) != 0) {
    throw std::system_error(errno, std::generic_category(), published.string());
  }
  fs::remove_all(made);
}

/// Leaves in `made` what readers need, as small as it can be.
void finish(const fs::path& made, const fs::path& project, const fs::path& published) {
  require_drawn(made, published);
  prune(made, project, published);
  shorten_summary(made / "summary.json");
  for (const auto& entry : fs::recursive_directory_iterator(made)) {
    if (entry.path().extension() == ".png") shrink_picture(entry.path());
  }
}

/// Writes what `ertbench run` or `ertbench fidelity` makes into `made`.
int make_results(const Experiment& experiment, const fs::path& project, const Cache& cache,
                 int jobs, const fs::path& published, const fs::path& made) {
  const bool models = experiment.made_by == "fidelity";
  const Stages stages =
      models ? stages_of_fidelity(fidelity_usual_scenes) : stages_of_run(experiment);
  RunOptions run;
  run.out = project / "results" / experiment.name;
  run.jobs = jobs;
  const bool limits = bring_limits(published, run.out);
  const ExperimentResults results = run_stages(stages, experiment, cache, run);
  if (models) {
    report_stages(stages, experiment, results, made);
    return results.failures;
  }
  if (limits && std::ranges::none_of(results.rows, is_limit)) {
    throw InputError(published.string() + ": its limits would be lost; compute them first: " +
                     "ertbench limit " + experiment.file.string());
  }
  report_experiment(experiment, cache, results, made);
  if (fs::exists(run.out / limit_ranks)) fs::copy_file(run.out / limit_ranks, made / limit_ranks);
  return results.failures;
}

}  // namespace

void prune(const fs::path& made, const fs::path& project, const fs::path& published) {
  const PageTexts texts(project, published);
  const std::vector<fs::directory_entry> entries(fs::recursive_directory_iterator(made), {});
  for (const fs::directory_entry& entry : entries) {
    if (entry.is_directory()) continue;
    const std::string file = fs::relative(entry.path(), made).string();
    if (file != "summary.json" && file != "provenance.json" &&
        !texts.name(published.filename().string(), file)) {
      fs::remove(entry.path());
    }
  }
  for (const fs::directory_entry& entry : entries) {
    if (entry.is_directory() && fs::is_empty(entry.path())) fs::remove(entry.path());
  }
}

void require_committed(const fs::path& project) {
  std::vector<std::string> changes;
  // With -z names stand as they are; without, git quotes those with blanks.
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
        "published can be reproduced");
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
                       int jobs) {
  const fs::path published = project / "results/published" / experiment.name;
  const fs::path made = empty_part_of(published);
  const int failures = make_results(experiment, project, cache, jobs, published, made);
  finish(made, project, published);
  replace_folder(published, made);
  // Charts and tables are those of the summary, whose numbers have fewer digits.
  if (experiment.made_by != "fidelity") redraw_published(experiment.name, project);
  return failures;
}

void redraw_published(const std::string& name, const fs::path& project) {
  const fs::path published = project / "results/published" / name;
  if (!fs::exists(published / "summary.json")) {
    throw InputError(published.string() + ": has no summary.json; ertbench publish makes it");
  }
  const fs::path made = empty_part_of(published);
  report_summary(published, made, chart_types());
  finish(made, project, published);
  fs::copy(published, made, fs::copy_options::recursive | fs::copy_options::skip_existing);
  replace_folder(published, made);
}

void publish_pages(const fs::path& project) {
  for (const auto& [page, text] : rendered_pages(project)) write_file_atomically(page, text);
}

}  // namespace ertbench
