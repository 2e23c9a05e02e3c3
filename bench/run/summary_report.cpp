#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/run/results.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The "presentation" of a summary. An earlier version wrote none: then the rows alone say which
/// test sets there are.
json presentation_in(JsonObject& summary) {
  if (summary.has("presentation")) return summary.object("presentation").value();
  json out = {{"test_sets", json::array()}, {"elsewhere", {"charts", "reconstructions"}}};
  for (JsonObject& row : summary.objects("rows")) {
    const json set = {{"name", row.text("dataset")}, {"description", "test set"}};
    json& sets = out["test_sets"];
    if (std::ranges::find(sets, set) == sets.end()) sets.push_back(set);
  }
  return out;
}

SolverEntry solver_entry(JsonObject& object) {
  SolverEntry entry;
  entry.label = object.text("label");
  entry.family = object.text_or("family", entry.label);
  if (object.has("sweep")) entry.sweep = object.object("sweep").value();
  entry.break_even_reference = object.boolean_or("break_even_reference", false);
  return entry;
}

/// As much of the experiment as reports are made of; puts the test sets' descriptions into `text`.
Experiment shown_experiment(JsonObject& summary, JsonObject& shown, const ChartTypes& charts,
                            TableText& text) {
  Experiment experiment;
  experiment.name = summary.text("experiment");
  experiment.title = summary.text("title");
  experiment.question = summary.text_or("question", experiment.title);
  for (JsonObject& set : shown.objects("test_sets")) {
    experiment.tests.emplace_back().name = set.text("name");
    text.dataset_descriptions[experiment.tests.back().name] = set.text("description");
  }
  if (experiment.tests.empty()) shown.fail("test_sets", "must name the test sets, it is empty");
  if (shown.has("solvers")) {
    for (JsonObject& solver : shown.objects("solvers")) {
      experiment.solvers.push_back(solver_entry(solver));
    }
  }
  experiment.validation.emplace();  // that of a right-sizing was there when it was run
  SolverRegistry registry;
  read_presentation(shown, experiment, charts, registry);
  return experiment;
}

void require_empty(const fs::path& folder) {
  if (!fs::exists(folder)) return;
  if (fs::is_directory(folder) && fs::is_empty(folder)) return;
  throw InputError("--out " + printable_path(folder.string()) +
                   ": there are files already; name a new or an empty folder");
}

}  // namespace

SummaryReport report_summary(const fs::path& results, const fs::path& out,
                             const ChartTypes& charts) {
  const fs::path file = results / "summary.json";
  if (!fs::exists(file)) {
    throw InputError(printable_path(results.string()) +
                     ": there is no summary.json; name the folder of a result, such as "
                     "results/published/table_c1");
  }
  require_empty(out);
  const json content = read_json_file(file);
  const std::string source = printable_path(file.string());
  JsonObject summary(content, source, "");
  summary.integer_or("schema", 1, 1, 1);  // an earlier version wrote none
  const json kept = presentation_in(summary);
  JsonObject shown(kept, source, "/presentation");
  TableText text;
  const Experiment experiment = shown_experiment(summary, shown, charts, text);
  text.title = experiment.title;
  text.published = experiment.published;
  text.command = summary.text("command");
  if (summary.has("builds")) text.builds = builds_from_json(summary.object("builds").value());
  summary.object("provenance").object("datasets");  // the page needs them
  std::vector<ResultRow> rows;
  for (JsonObject& row : summary.objects("rows")) {
    rows.push_back(result_row_from_json(std::move(row)));
  }
  SummaryReport report{0, {}, text.command};
  for (const json& name : shown.raw("elsewhere")) {
    if (name.is_string()) report.elsewhere.push_back(printable(name.get<std::string>()));
  }
  fs::create_directories(out);
  report.undrawn = write_rows(experiment, rows, text, {}, content, out);
  return report;
}

}  // namespace ertbench
