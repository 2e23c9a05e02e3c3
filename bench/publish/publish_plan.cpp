#include "bench/publish/publish_plan.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/record/limit_file.h"
#include "bench/record/record_file.h"
#include "bench/record/stamps.h"
#include "core/build_stamp.h"
#include "core/json.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double seconds_of_an_hour = 3600;

/// The seconds of a fit by label, from published results; empty where there are none. Results that
/// cannot be read tell nothing.
std::map<std::string, double> published_seconds(const fs::path& summary) {
  std::map<std::string, double> out;
  if (!fs::exists(summary)) return out;
  try {
    const json results = read_json_file(summary);
    for (const json& row : results.at("rows")) {
      if (row.value("fit_s", json()).is_number()) {
        out[row.at("label").get<std::string>()] = row.at("fit_s").get<double>();
      }
    }
  } catch (const std::exception&) {
    out.clear();
  }
  return out;
}

/// What stands beside a fitted solver in the cache (bench/run/fitted_solver).
struct CachedFit {
  bool current = false;  ///< its probes are those of this program
  std::optional<double> seconds;
};

/// Nothing is known of a fit whose note cannot be read, and it will be made again.
CachedFit cached_fit(const FitRecipe& recipe, fs::path file) {
  CachedFit out;
  if (!fs::exists(file)) return out;
  file += ".json";
  try {
    const json note = read_json_file(file);
    const std::optional<BuildStamp> build = build_stamp_from_json(note.at("build"));
    out.current = build && !build->dirty &&
                  probe_difference(build->probes, stamp_of_fit(recipe).probes).empty();
    out.seconds = note.at("fit_s").get<double>();
  } catch (const std::exception&) {
    return {};
  }
  return out;
}

/// The seconds that the frames took of a folder's limits that may not be published again as they
/// are. Limits that cannot be read tell nothing.
double limit_seconds(const fs::path& folder, const Experiment& experiment) {
  if (!fs::exists(folder / limit_file)) return 0;
  double seconds = 0;
  try {
    std::vector<ResultRow> usable;
    add_limit_rows(folder,
                   {experiment.tests, experiment.training ? &*experiment.training : nullptr},
                   Reuse::clean, usable);
    const json limits = read_json_file(folder / limit_file);
    for (const json& set : limits.at("sets")) {
      const std::string type = set.at("prior") == "oracle" ? limit_oracle : limit_fair;
      const bool stays = std::any_of(usable.begin(), usable.end(), [&](const ResultRow& row) {
        return row.dataset == set.at("dataset") && row.type == type;
      });
      if (stays) continue;
      for (const json& frame : set.at("per_frame")) seconds += frame.at("seconds").get<double>();
    }
  } catch (const std::exception&) {
    return 0;
  }
  return seconds;
}

std::string hours_text(double seconds) { return fixed(seconds / seconds_of_an_hour, 2); }

}  // namespace

PublishPlan::PublishPlan(fs::path project, Cache cache)
    : project_(std::move(project)), cache_(std::move(cache)) {}

void PublishPlan::add(const Experiment& experiment) {
  PublishCost& cost = costs_.emplace_back();
  cost.experiment = experiment.name;
  const fs::path published = project_ / "results/published" / experiment.name;
  cost.limit_seconds = limit_seconds(published, experiment);
  const std::map<std::string, double> known = published_seconds(published / "summary.json");
  for (const SolverEntry& entry : experiment.solvers) {
    ++cost.fits;
    const FitRecipe recipe = fit_recipe(experiment, entry);
    const fs::path file = cache_.fitted_solver(recipe);
    const CachedFit cached = cached_fit(recipe, file);
    if (!counted_.insert(file).second || cached.current) {
      ++cost.kept;
      continue;
    }
    const auto found = known.find(entry.label);
    if (cached.seconds) {
      cost.seconds += *cached.seconds;
    } else if (found != known.end()) {
      cost.seconds += found->second;
    } else {
      ++cost.unknown;
    }
  }
}

Table PublishPlan::table(int jobs) const {
  TableSection section;
  section.columns = {{"experiment", Align::left}, {"fits"},     {"kept"}, {"to be made, h"},
                     {"of unknown length"},       {"limits, h"}};
  PublishCost sum;
  sum.experiment = "all";
  for (const PublishCost& cost : costs_) {
    sum.fits += cost.fits;
    sum.kept += cost.kept;
    sum.unknown += cost.unknown;
    sum.seconds += cost.seconds;
    sum.limit_seconds += cost.limit_seconds;
  }
  std::vector<PublishCost> rows = costs_;
  rows.push_back(sum);
  for (const PublishCost& cost : rows) {
    section.rows.push_back({cost.experiment, std::to_string(cost.fits), std::to_string(cost.kept),
                            hours_text(cost.seconds), std::to_string(cost.unknown),
                            hours_text(cost.limit_seconds)});
  }
  section.notes.push_back("Some " +
                          fixed((sum.seconds + sum.limit_seconds) / seconds_of_an_hour / jobs, 1) +
                          " hours of fits and limits with " + std::to_string(jobs) + " at a time.");
  return {
      "What publishing will take",
      "Hours of fitting, one fit at a time, as the cached or the published ones took; "
      "scoring and timing come on top. Kept: fits that are in the cache and of this code, or "
      "another experiment's too. Limits: hours, one frame at a time, of the published ones that "
      "are of other probes or other sets by now; the others stay.",
      {section},
      {},
      {}};
}

}  // namespace ertbench
