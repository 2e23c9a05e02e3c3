#include "bench/record/limit_file.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "core/build_stamp.h"
#include "core/json.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {

bool is_limit(const ResultRow& row) {
  return row.type == limit_oracle || row.type == limit_fair || row.type == limit_lower;
}

std::vector<ResultRow> read_limit_rows(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / limit_file;
  if (!std::filesystem::exists(file)) return {};
  const nlohmann::json json = read_json_file(file);
  JsonObject root(json, file.string(), "");
  std::vector<ResultRow> rows;
  for (const JsonObject& row : root.objects("rows")) {
    rows.push_back(result_row_from_json(row));
    if (!is_limit(rows.back())) root.fail("rows", "must be of the types of limits");
  }
  return rows;
}

std::string limit_key(const DatasetSpec& set, const DatasetSpec& scenes) {
  nlohmann::json key = {{"set", to_json(set)},
                        {"scenes", to_json(scenes).value("scenes", nlohmann::json())}};
  key["set"].erase("count");
  return hash_of(key.dump());
}

namespace {

/// Why a row of limits is not to be shown; empty where it is.
std::string why_not(const ResultRow& limit, const LimitSets& sets, Reuse reuse) {
  const auto test = std::ranges::find(sets.tests, limit.dataset, &DatasetSpec::name);
  if (test == sets.tests.end()) return "it is of another set";
  const DatasetSpec* scenes = limit.type == limit_fair ? sets.training : &*test;
  if (!scenes || limit.parameters->value("set", "") != limit_key(*test, *scenes)) {
    return "it is of other scenes";
  }
  const BuildStamp now = stamp_of_limit(*test, *scenes);
  if (limit.build.scored.empty()) return why_stale(std::nullopt, now, Reuse::same_code);
  for (const BuildStamp& made : limit.build.scored) {
    // No run computes a limit again: what another program with the same probes found stays.
    std::string why = why_stale(made, now, reuse == Reuse::clean ? reuse : Reuse::same_code);
    if (!why.empty()) return why;
  }
  return "";
}

/// The relative errors of the oracle's estimates by the numbers of their frames.
std::map<std::size_t, double> errors_of_limit(const std::filesystem::path& folder,
                                              const std::string& dataset) {
  const std::filesystem::path file = folder / limit_file;
  const nlohmann::json json = read_json_file(file);
  JsonObject root(json, file.string(), "");
  std::map<std::size_t, double> out;
  for (JsonObject& set : root.objects("sets")) {
    if (set.text("dataset") != dataset || set.text("prior") != "oracle") continue;
    for (JsonObject& frame : set.objects("per_frame")) {
      JsonObject metrics = frame.object("metrics");
      if (!metrics.has("relative_error")) continue;
      JsonObject both = metrics.object("relative_error");
      if (both.raw("error").is_null()) continue;
      out[static_cast<std::size_t>(frame.number("frame", {0, 1e15}))] = both.number("error");
    }
  }
  return out;
}

/// The mean over the seeds of a frame's error; nothing where one of them has none.
std::optional<double> error_of(const FramesOfSeeds& trials, std::size_t frame) {
  double sum = 0;
  for (const std::vector<FrameMetrics>& frames : trials) {
    if (frame >= frames.size() || !frames[frame][Metric::relative_error]) return std::nullopt;
    sum += *frames[frame][Metric::relative_error];
  }
  if (trials.empty()) return std::nullopt;
  return sum / static_cast<double>(trials.size());
}

std::optional<OverLimit> over_limit(const FramesOfSeeds& trials,
                                    const std::map<std::size_t, double>& limits,
                                    const std::string& name) {
  std::vector<double> errors;
  std::vector<double> least;
  for (const auto& [frame, limit] : limits) {
    const std::optional<double> error = error_of(trials, frame);
    if (!error) continue;
    errors.push_back(*error);
    least.push_back(limit);
  }
  const std::optional<RatioOfSums> found = ratio_of_sums(errors, least, name);
  if (!found) return std::nullopt;
  return OverLimit{found->ratio, found->ci95, static_cast<int>(errors.size())};
}

}  // namespace

void add_limit_rows(const std::filesystem::path& folder, const LimitSets& sets, Reuse reuse,
                    std::vector<ResultRow>& rows) {
  for (const ResultRow& limit : read_limit_rows(folder)) {
    const std::string why = why_not(limit, sets, reuse);
    if (!why.empty()) {
      spdlog::warn("{}: {} of \"{}\" is left out: {}; run `ertbench limit` again",
                   (folder / limit_file).string(), limit.label, printable(limit.dataset), why);
      continue;
    }
    const auto last = std::find_if(rows.rbegin(), rows.rend(), [&](const ResultRow& row) {
      return row.dataset == limit.dataset &&
             (row.type == "truth" || row.type == "no-contact" || is_limit(row));
    });
    ResultRow& row = *rows.insert(last.base(), limit);
    for (BuildStamp& stamp : row.build.scored)
      stamp.probes.clear();  // compared, and of no more use
  }
}

void compare_with_limits(const std::filesystem::path& folder, std::span<const ScoredLabels> sets,
                         std::vector<ResultRow>& rows) {
  for (const ScoredLabels& set : sets) {
    if (!limit_of(rows, set.dataset)) continue;
    const std::map<std::size_t, double> limits = errors_of_limit(folder, set.dataset);
    for (std::size_t i = 0; i < set.labels.size(); ++i) {
      for (ResultRow& row : rows) {
        if (row.dataset != set.dataset || row.label != set.labels[i]) continue;
        row.over_limit = over_limit(set.frames[i], limits, set.dataset + " " + row.label);
      }
    }
  }
}

const ResultRow* limit_of(std::span<const ResultRow> rows, const std::string& dataset) {
  return find_row(rows, limit_oracle, dataset);
}

}  // namespace ertbench
