#include "bench/record/result_row.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/json.h"

namespace ertbench {

std::string text_of(const Builds& builds) {
  std::map<std::string, std::string> made;  // what each build made
  bool dirty = false;
  for (const auto& [stage, stamps] : builds) {
    for (const BuildStamp& stamp : stamps) {
      std::string& what =
          made["commit " + stamp.commit_text() + ", program " + stamp.program.substr(0, 8)];
      what += (what.empty() ? "" : ", ") + stage;
      dirty = dirty || stamp.dirty;
    }
  }
  if (made.empty()) return "";
  std::string out;
  if (made.size() == 1) {
    out = "build: " + made.begin()->first + ".";
  } else {
    out = "Made of records of " + std::to_string(made.size()) +
          " builds of the program, whose probes agree:";
    for (const auto& [build, what] : made)
      out.append(" ").append(build).append(" (").append(what).append(");");
    out.back() = '.';
  }
  if (dirty) out += " dirty: with changes that were not committed.";
  return out;
}

namespace {

using nlohmann::json;

json to_json(const std::vector<BuildStamp>& stamps) {
  json out = json::array();
  for (const BuildStamp& stamp : stamps) out.push_back(to_json(stamp));
  return out;
}

std::vector<BuildStamp> stamps_from(const json& list) {
  std::vector<BuildStamp> out;
  for (const json& stamp : list) {
    if (auto build = build_stamp_from_json(stamp)) out.push_back(std::move(*build));
  }
  return out;
}

}  // namespace

json to_json(const Builds& builds) {
  json out = json::object();
  for (const auto& [stage, stamps] : builds) out[stage] = to_json(stamps);
  return out;
}

Builds builds_from_json(const json& builds) {
  Builds out;
  for (const auto& [stage, stamps] : builds.items()) out[stage] = stamps_from(stamps);
  return out;
}

namespace {

json or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? json(*value) : json(nullptr);
}

json or_null(const std::optional<Interval>& interval) {
  return interval ? json{interval->low, interval->high} : json(nullptr);
}

json to_json(const MetricSummary& summary) {
  return {{"mean", or_null(summary.mean)},
          {"ci95", or_null(summary.ci95)},
          {"median", or_null(summary.median)},
          {"median_ci95", or_null(summary.median_ci95)},
          {"count", summary.count},
          {"undefined", summary.undefined}};
}

/// `frames`: that were scored, with or without a value. A metric for which none of them counts is
/// one that the set's truth does not tell, and is left out.
json to_json(const PerMetric<MetricSummary>& metrics, int frames) {
  json out = json::object();
  for (const Metric metric : kMetrics) {
    const MetricSummary& summary = metrics[metric];
    if (frames > 0 && summary.count + summary.undefined == 0) continue;
    out[name_of(metric)] = to_json(summary);
  }
  return out;
}

json to_json(const LatencySummary& latency) {
  json out = {{"p50", latency.p50},
              {"p99", latency.p99},
              {"max", latency.max},
              {"p50_of_rounds", latency.p50_of_rounds},
              {"relative_of_rounds", latency.relative_of_rounds}};
  if (latency.pipe) out["pipe"] = or_null(latency.pipe);
  if (latency.contacts_p50) {
    out["contacts_p50"] = or_null(latency.contacts_p50);
    out["contacts_p99"] = or_null(latency.contacts_p99);
  }
  return out;
}

json to_json(const RowBuilds& builds) {
  json out = to_json(builds.scored.front());
  out["scored"] = to_json(builds.scored);
  out["fitted"] = to_json(builds.fitted);
  out["timed"] = to_json(builds.timed);
  return out;
}

RowBuilds builds_from(const json& builds) {
  const auto part = [&](const char* name) {
    return stamps_from(builds.value(name, json::array()));
  };
  return {part("scored"), part("fitted"), part("timed")};
}

json or_null(const std::vector<std::optional<double>>& values) {
  json out = json::array();
  for (const auto& value : values) out.push_back(or_null(value));
  return out;
}

json to_json(const SeedSpread& seeds) {
  json out = {
      {"values", seeds.values}, {"fit_s", or_null(seeds.fit_s)}, {"parameters", *seeds.parameters}};
  for (const Metric metric : kMetrics) {
    out["means"][name_of(metric)] = or_null(seeds.means[metric]);
    out["deviation"][name_of(metric)] = or_null(seeds.deviation[metric]);
  }
  return out;
}

bool is_null(JsonObject& object, const char* key) { return object.raw(key).is_null(); }

int count(JsonObject& object, const char* key) {
  return object.integer(key, 0, std::numeric_limits<int>::max());
}

/// A string that may be empty.
std::string any_text(JsonObject& object, const char* key) {
  const json& value = object.raw(key);
  if (!value.is_string()) object.fail(key, "must be a string");
  return value.get<std::string>();
}

std::optional<double> number_or_null(JsonObject& object, const char* key) {
  if (is_null(object, key)) return std::nullopt;
  return object.number(key);
}

std::optional<Interval> interval_or_null(JsonObject& object, const char* key) {
  if (is_null(object, key)) return std::nullopt;
  const auto ends = object.numbers(key, 2);
  return Interval{ends[0], ends[1]};
}

MetricSummary metric_summary_from_json(JsonObject object) {
  MetricSummary summary;
  summary.mean = number_or_null(object, "mean");
  summary.ci95 = interval_or_null(object, "ci95");
  summary.median = number_or_null(object, "median");
  if (object.has("median_ci95")) summary.median_ci95 = interval_or_null(object, "median_ci95");
  summary.count = count(object, "count");
  summary.undefined = count(object, "undefined");
  object.finish();
  return summary;
}

PerMetric<MetricSummary> metrics_from_json(JsonObject object) {
  PerMetric<MetricSummary> metrics;
  for (const Metric metric : kMetrics) {
    const char* key = key_in_file(metric, [&](const char* k) { return object.has(k); });
    if (key == nullptr) continue;  // written before there was this metric
    metrics[metric] = metric_summary_from_json(object.object(key));
  }
  object.finish();
  return metrics;
}

std::vector<std::optional<double>> numbers_or_null(JsonObject& object, const char* key,
                                                   std::size_t size) {
  const json& values = object.raw(key);
  if (!values.is_array() || values.size() != size) {
    object.fail(key, "must be a list of " + std::to_string(size) + " numbers, one for each seed");
  }
  std::vector<std::optional<double>> out;
  for (const json& value : values) {
    if (!value.is_null() && !value.is_number()) object.fail(key, "must hold numbers or null");
    out.push_back(value.is_null() ? std::nullopt : std::optional(value.get<double>()));
  }
  return out;
}

SeedSpread seeds_from_json(JsonObject object) {
  SeedSpread seeds;
  const json& values = object.raw("values");
  const bool whole =
      values.is_array() && std::all_of(values.begin(), values.end(),
                                       [](const json& v) { return v.is_number_integer(); });
  if (!whole) object.fail("values", "must be a list of whole numbers");
  seeds.values = values.get<std::vector<int>>();
  JsonObject means = object.object("means");
  JsonObject deviation = object.object("deviation");
  for (const Metric metric : kMetrics) {
    seeds.means[metric].resize(seeds.values.size());
    const char* key = key_in_file(metric, [&](const char* k) { return means.has(k); });
    if (key == nullptr) continue;
    seeds.means[metric] = numbers_or_null(means, key, seeds.values.size());
    seeds.deviation[metric] = number_or_null(deviation, key);
  }
  means.finish();
  deviation.finish();
  seeds.fit_s = numbers_or_null(object, "fit_s", seeds.values.size());
  seeds.parameters = object.raw("parameters");
  object.finish();
  return seeds;
}

/// Empty where an earlier version wrote none.
std::vector<double> rounds_from_json(JsonObject& object, const char* name) {
  if (!object.has(name)) return {};
  const json& rounds = object.raw(name);
  const bool numbers =
      rounds.is_array() &&
      std::all_of(rounds.begin(), rounds.end(), [](const json& v) { return v.is_number(); });
  if (!numbers) object.fail(name, "must be a list of numbers");
  return rounds.get<std::vector<double>>();
}

LatencySummary latency_from_json(JsonObject object) {
  LatencySummary latency{object.number("p50"), object.number("p99"), object.number("max"),
                         rounds_from_json(object, "p50_of_rounds"),
                         rounds_from_json(object, "relative_of_rounds")};
  if (object.has("pipe")) latency.pipe = number_or_null(object, "pipe");
  if (object.has("contacts_p50")) {
    latency.contacts_p50 = number_or_null(object, "contacts_p50");
    latency.contacts_p99 = number_or_null(object, "contacts_p99");
  }
  object.finish();
  return latency;
}

TimingPlace place_from_json(JsonObject object) {
  TimingPlace place{any_text(object, "cpu"), any_text(object, "node"),
                    object.number("busy_cores", {0, 1e6})};
  object.finish();
  return place;
}

}  // namespace

json to_json(const ResultRow& row) {
  json out = {{"label", row.label},
              {"type", row.type},
              {"family", row.family},
              {"dataset", row.dataset},
              {"status", row.status},
              {"message", row.message},
              {"parameters", *row.parameters},
              {"frames", row.frames},
              {"undefined_frames", row.undefined_frames},
              {"frames_not_converged", row.frames_not_converged},
              {"suspect_frames", row.suspect_frames},
              {"metrics", to_json(row.metrics, row.frames)},
              {"latency_us", row.latency_us ? to_json(*row.latency_us) : json(nullptr)},
              {"calibration_us", or_null(row.calibration_us)},
              {"frames_per_s", or_null(row.frames_per_s)},
              {"throughput_batch", row.throughput_batch},
              {"fit_s", or_null(row.fit_s)},
              {"peak_rss_mb", or_null(row.peak_rss_mb)}};
  if (!row.build.scored.empty()) out["build"] = to_json(row.build);
  if (row.timed_on) {
    out["timed_on"] = {{"cpu", row.timed_on->cpu},
                       {"node", row.timed_on->node},
                       {"busy_cores", row.timed_on->busy_cores}};
  }
  if (row.validation) out["validation"] = to_json(*row.validation, 0);
  if (row.over_limit) {
    const OverLimit& over = *row.over_limit;
    out["over_limit"] = {
        {"ratio", over.ratio}, {"ci95", {over.ci95.low, over.ci95.high}}, {"frames", over.frames}};
  }
  if (row.seeds) out["seeds"] = to_json(*row.seeds);
  if (row.sweep) out["sweep"] = *row.sweep;
  return out;
}

ResultRow result_row_from_json(JsonObject object) {
  ResultRow row;
  row.label = object.text("label");
  row.type = object.text("type");
  row.family = object.has("family") ? any_text(object, "family") : row.label;
  row.dataset = object.text("dataset");
  row.status = object.text("status");
  row.message = any_text(object, "message");
  row.parameters = object.raw("parameters");
  row.frames = count(object, "frames");
  row.undefined_frames = count(object, "undefined_frames");
  row.frames_not_converged = count(object, "frames_not_converged");
  if (object.has("suspect_frames")) row.suspect_frames = count(object, "suspect_frames");
  row.metrics = metrics_from_json(object.object("metrics"));
  if (object.has("validation")) row.validation = metrics_from_json(object.object("validation"));
  if (object.has("over_limit")) {
    JsonObject over = object.object("over_limit");
    const std::vector<double> ci95 = over.numbers("ci95", 2);
    row.over_limit = {over.number("ratio"), {ci95[0], ci95[1]}, over.integer("frames", 1, 1 << 30)};
    over.finish();
  }
  if (!is_null(object, "latency_us")) {
    row.latency_us = latency_from_json(object.object("latency_us"));
  }
  if (object.has("calibration_us")) row.calibration_us = number_or_null(object, "calibration_us");
  if (object.has("timed_on")) row.timed_on = place_from_json(object.object("timed_on"));
  row.frames_per_s = number_or_null(object, "frames_per_s");
  row.throughput_batch = count(object, "throughput_batch");
  row.fit_s = number_or_null(object, "fit_s");
  row.peak_rss_mb = number_or_null(object, "peak_rss_mb");
  if (object.has("seeds")) row.seeds = seeds_from_json(object.object("seeds"));
  if (object.has("build")) row.build = builds_from(object.object("build").value());
  if (object.has("sweep")) row.sweep = object.object("sweep").value();
  object.finish();
  return row;
}

namespace {

void count(const json& parameters, Convergence& convergence) {
  if (!parameters.is_object() || !parameters.contains("training")) return;
  const json& training = parameters.at("training");
  if (!training.is_object() || !training.contains("best_epoch")) return;
  ++convergence.runs;
  const json& best = training.at("best_epoch");
  const json allowed = parameters.value("epochs", json());
  const json said = training.value("converged", json());
  const bool last = best.is_number() && allowed.is_number() && best >= allowed;
  if (said.is_boolean() ? !said.get<bool>() : last) ++convergence.not_converged;
}

}  // namespace

Convergence convergence_of(const ResultRow& row) {
  Convergence convergence;
  if (!row.seeds || row.seeds->parameters->empty()) {
    count(*row.parameters, convergence);
    return convergence;
  }
  for (const json& different : *row.seeds->parameters) {
    json parameters = *row.parameters;
    parameters.update(different);
    count(parameters, convergence);
  }
  return convergence;
}

}  // namespace ertbench
