#include "bench/publish/published_result.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/publish/clocks.h"
#include "bench/publish/published_folder.h"
#include "bench/record/limit_file.h"
#include "bench/run/results.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Throws InputError where the experiment is no longer the one that was published.
void require_same(const Experiment& experiment, const std::string& where,
                  const PublishedResult& published) {
  if (!experiment.studies.empty() || experiment.ladders || experiment.folds) {
    throw InputError(where +
                     ": its studies, ladders or folds are made with the times, or take no "
                     "times; publish " +
                     experiment.name + " again as a whole");
  }
  const json& datasets = published.summary->at("provenance").at("datasets");
  for (const DatasetSpec* spec : experiment.datasets()) {
    if (datasets.value(spec->name, json()) == json(to_json(*spec))) continue;
    throw InputError(where + ": the dataset \"" + spec->name + "\" of " + experiment.file.string() +
                     " is no longer the one it was published with; "
                     "publish it again");
  }
  for (const ResultRow& row : published.rows) {
    if (!row.latency_us) continue;
    const auto entry = std::find_if(experiment.solvers.begin(), experiment.solvers.end(),
                                    [&](const SolverEntry& e) { return e.label == row.label; });
    if (entry != experiment.solvers.end() && entry->type == row.type) continue;
    throw InputError(where + ": " + experiment.file.string() + " has no solver \"" +
                     printable(row.label) + "\" any more; publish it again");
  }
}

/// Whether a row is of a solver, which has a time.
bool is_timed(const ResultRow& row) {
  return row.ok() && row.type != "truth" && row.type != "no-contact" && !is_limit(row);
}

void copy_times(const ResultRow& from, ResultRow& to) {
  to.latency_us = from.latency_us;
  to.calibration_us = from.calibration_us;
  to.timed_on = from.timed_on;
  to.frames_per_s = from.frames_per_s;
  to.throughput_batch = from.throughput_batch;
  to.peak_rss_mb = from.peak_rss_mb;
  to.build.timed = from.build.timed;
}

/// The same as read_published, timed or not.
PublishedResult read_rows(const Experiment& experiment, const fs::path& folder) {
  const std::string where = (folder / "summary.json").string();
  if (!fs::exists(where)) {
    const fs::path rates = folder / "load.json";
    if (fs::exists(rates)) {
      throw InputError(rates.string() + ": there are rates of frames alone, which " +
                       "./ertbench publish --load " + experiment.file.string() + " takes again");
    }
    throw InputError(where + ": there is no such result; ./ertbench publish " +
                     experiment.file.string() + " makes it");
  }
  PublishedResult published{folder, read_json_file(where), {}};
  JsonObject root(*published.summary, where, "");
  for (const JsonObject& object : root.objects("rows")) {
    published.rows.push_back(result_row_from_json(object));
  }
  require_same(experiment, where, published);
  return published;
}

}  // namespace

PublishedResult read_published(const Experiment& experiment, const fs::path& folder) {
  PublishedResult published = read_rows(experiment, folder);
  const std::string where = (folder / "summary.json").string();
  if (!experiment.timing.enabled) {
    throw InputError(where + ": " + experiment.name + " takes no times (/timing/enabled)");
  }
  if (std::none_of(published.rows.begin(), published.rows.end(),
                   [](const ResultRow& row) { return row.latency_us.has_value(); })) {
    throw InputError(where + ": none of its rows was timed");
  }
  return published;
}

json clocks_of(const PublishedResult& published) {
  if (published.summary->contains("clocks")) return published.summary->at("clocks");
  const json& provenance = published.summary->at("provenance");
  std::string build = "commit " + provenance.value("commit", "unknown");
  for (const ResultRow& row : published.rows) {
    if (row.build.timed.empty()) continue;
    const BuildStamp& stamp = row.build.timed.front();
    build = "commit " + stamp.commit_text() + ", program " + stamp.program.substr(0, 8);
    break;
  }
  return {{"date", provenance.value("date", "")},     {"cpu", provenance.value("cpu", "")},
          {"system", provenance.value("system", "")}, {"build", build},
          {"together_with", json::array()},           {"briefly_trained", json::array()}};
}

std::string clocks_sentence(const json& clocks) {
  std::string others;
  for (const json& name : clocks.at("together_with")) {
    others += (others.empty() ? "" : ", ") + name.get<std::string>();
  }
  std::string out = "Times: taken apart from all other numbers, at " +
                    clocks.at("date").get<std::string>() + " by " +
                    clocks.at("build").get<std::string>();
  if (!others.empty()) out += ", in the same rounds as those of " + others;
  out += ".";
  if (!clocks.at("briefly_trained").empty()) {
    out += " For the clock the networks were trained for one epoch of " +
           std::to_string(clock_scenes) + " scenes: what a frame costs does not depend on weights.";
  }
  return out;
}

void take_times(const PublishedResult& published, const Experiment& experiment,
                std::vector<ResultRow>& rows) {
  for (ResultRow& row : rows) {
    if (!is_timed(row)) continue;
    const auto old =
        std::find_if(published.rows.begin(), published.rows.end(), [&](const ResultRow& other) {
          return other.label == row.label && other.dataset == row.dataset && other.latency_us;
        });
    if (old == published.rows.end()) {
      throw InputError((published.folder / "summary.json").string() + ": \"" +
                       printable(row.label) + "\" has no time in it; publish " + experiment.name +
                       " as a whole");
    }
    copy_times(*old, row);
  }
}

std::size_t write_clocks(const PublishedResult& published, const Experiment& experiment,
                         const std::vector<ResultRow>& rows, const fs::path& made) {
  json summary = read_json_file(made / "summary.json");
  summary["clocks"] = clocks_of(published);
  const json builds = published.summary->value("builds", json::object());
  if (builds.contains("timing")) summary["builds"]["timing"] = builds.at("timing");
  const std::string sentence = clocks_sentence(summary.at("clocks"));
  return rewrite_results(experiment, rows, sentence, std::move(summary), made);
}

void rewrite_published(const Experiment& experiment, const fs::path& folder,
                       const std::vector<ResultRow>& rows, const json& summary) {
  const fs::path made = copied_part_of(folder);
  const std::string clocks =
      summary.contains("clocks") ? clocks_sentence(summary.at("clocks")) : std::string();
  if (rewrite_results(experiment, rows, clocks, summary, made) > 0) {
    fs::remove_all(made);
    throw InputError(folder.string() +
                     ": a figure could not be drawn, as said above; what was published before is "
                     "as it was");
  }
  replace_folder(folder, made);
}

void redraw_published(const Experiment& experiment, const fs::path& folder) {
  const PublishedResult published = read_rows(experiment, folder);
  rewrite_published(experiment, folder, published.rows, *published.summary);
}

}  // namespace ertbench
