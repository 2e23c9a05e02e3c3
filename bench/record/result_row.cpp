#include "bench/record/result_row.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/fields.h"
#include "core/statistics.h"

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

constexpr int most = std::numeric_limits<int>::max();

void visit(Fields& fields, const char* key, std::optional<Interval>& interval) {
  std::optional<std::pair<double, double>> ends;
  if (interval) ends.emplace(interval->low, interval->high);
  fields.nullable().interval(key, ends, {});
  if (fields.reading() && ends) interval = Interval{ends->first, ends->second};
}

void visit(Fields& fields, MetricSummary& summary) {
  fields.required().nullable().number("mean", summary.mean, {});
  visit(fields.required(), "ci95", summary.ci95);
  fields.required().nullable().number("median", summary.median, {});
  visit(fields, "median_ci95", summary.median_ci95);
  fields.required().integer("count", summary.count, 0, most);
  fields.required().integer("undefined", summary.undefined, 0, most);
}

/// Calls `use(key, metric)` for the metrics that an object has, which knows some by older names.
template <typename Use>
void each_metric(Fields& fields, const Use& use) {
  for (const Metric metric : kMetrics) {
    const char* key = fields.reading()
                          ? key_in_file(metric, [&](const char* k) { return fields.has(k); })
                          : name_of(metric);
    if (key != nullptr) use(key, metric);
  }
}

/// `frames`: that were scored, with or without a value. A metric for which none of them counts is
/// one that the set's truth does not tell, and is left out.
void visit(Fields& fields, PerMetric<MetricSummary>& metrics, int frames) {
  each_metric(fields, [&](const char* key, Metric metric) {
    MetricSummary& summary = metrics[metric];
    if (fields.writing() && frames > 0 && summary.count + summary.undefined == 0) return;
    fields.object(key, [&](Fields& one) { visit(one, summary); });
  });
}

void visit(Fields& fields, LatencySummary& latency) {
  fields.required().number("p50", latency.p50, {});
  fields.required().number("p99", latency.p99, {});
  fields.required().number("max", latency.max, {});
  // Earlier versions wrote no rounds, or an empty list.
  for (const auto& [key, rounds] : {std::pair("p50_of_rounds", &latency.p50_of_rounds),
                                    std::pair("relative_of_rounds", &latency.relative_of_rounds)}) {
    JsonValue list = json(*rounds);
    fields.any(key, list);
    if (!fields.reading()) continue;
    const bool numbers = list->is_array() && std::ranges::all_of(*list, &json::is_number);
    if (!numbers) fields.fail(key, "must be a list of numbers");
    *rounds = list->get<std::vector<double>>();
  }
  fields.number("pipe", latency.pipe, {});
  fields.number("contacts_p50", latency.contacts_p50, {});
  fields.number("contacts_p99", latency.contacts_p99, {});
  if (latency.contacts_p50.has_value() != latency.contacts_p99.has_value()) {
    fields.fail("contacts_p99", "is there only beside contacts_p50");
  }
}

void visit(Fields& fields, TimingPlace& place) {
  fields.required().words("cpu", place.cpu);
  fields.required().words("node", place.node);
  fields.required().number("busy_cores", place.busy_cores, {0, 1e6});
}

void visit(Fields& fields, OverLimit& over) {
  std::optional<Interval> ci95 = over.ci95;
  fields.required().number("ratio", over.ratio, {});
  visit(fields.required(), "ci95", ci95);
  fields.required().integer("frames", over.frames, 1, 1 << 30);
  over.ci95 = *ci95;
}

json list_of(const std::vector<std::optional<double>>& values) {
  json out = json::array();
  for (const auto& value : values) {
    out.push_back(value && std::isfinite(*value) ? json(*value) : json());
  }
  return out;
}

/// A number or null for each of `size` seeds.
void visit(Fields& fields, const char* key, std::vector<std::optional<double>>& values,
           std::size_t size) {
  JsonValue list = list_of(values);
  fields.required().any(key, list);
  if (!fields.reading()) return;
  if (!list->is_array() || list->size() != size) {
    fields.fail(key, "must be a list of " + std::to_string(size) + " numbers, one for each seed");
  }
  values.clear();
  for (const json& value : *list) {
    if (!value.is_null() && !value.is_number()) fields.fail(key, "must hold numbers or null");
    values.push_back(value.is_null() ? std::nullopt : std::optional(value.get<double>()));
  }
}

void visit(Fields& fields, SeedSpread& seeds) {
  fields.required().integers("values", seeds.values, 0, 100000, {-most, most});
  const std::size_t size = seeds.values.size();
  if (fields.reading()) {
    for (const Metric metric : kMetrics) seeds.means[metric].resize(size);
  }
  fields.required().object("means", [&](Fields& means) {
    each_metric(means, [&](const char* key, Metric metric) {
      visit(means, key, seeds.means[metric], size);
    });
  });
  fields.required().object("deviation", [&](Fields& deviation) {
    each_metric(deviation, [&](const char* key, Metric metric) {
      deviation.nullable().number(key, seeds.deviation[metric], {});
    });
  });
  visit(fields, "fit_s", seeds.fit_s, size);
  fields.required().any("parameters", seeds.parameters);
}

json to_json(const RowBuilds& builds) {
  json out = to_json(builds.scored.front());
  out["scored"] = to_json(builds.scored);
  out["fitted"] = to_json(builds.fitted);
  out["timed"] = to_json(builds.timed);
  return out;
}

void visit(Fields& fields, RowBuilds& builds) {
  JsonValue value;
  if (fields.writing() && !builds.scored.empty()) value = to_json(builds);
  fields.any("build", value);
  if (!fields.reading() || !value) return;
  if (!value->is_object()) fields.fail("build", "must be an object");
  const auto part = [&](const char* name) {
    return stamps_from(value->value(name, json::array()));
  };
  builds = {part("scored"), part("fitted"), part("timed")};
}

void visit(Fields& fields, ResultRow& row) {
  fields.required().text("label", row.label);
  fields.required().text("type", row.type);
  if (fields.reading()) row.family = row.label;  // of a row from before there were families
  fields.words("family", row.family);
  fields.required().text("dataset", row.dataset);
  fields.required().text("status", row.status);
  fields.required().words("message", row.message);
  fields.required().any("parameters", row.parameters);
  if (!row.parameters->is_object()) fields.fail("parameters", "must be an object");
  fields.required().integer("frames", row.frames, 0, most);
  fields.required().integer("undefined_frames", row.undefined_frames, 0, most);
  fields.required().integer("frames_not_converged", row.frames_not_converged, 0, most);
  fields.integer("suspect_frames", row.suspect_frames, 0, most);
  fields.required().object("metrics",
                           [&](Fields& metrics) { visit(metrics, row.metrics, row.frames); });
  fields.object("validation", row.validation,
                [](Fields& metrics, PerMetric<MetricSummary>& all) { visit(metrics, all, 0); });
  const auto visit_struct = [](Fields& of, auto& one) { visit(of, one); };
  fields.object("over_limit", row.over_limit, visit_struct);
  fields.required().nullable().object("latency_us", row.latency_us, visit_struct);
  fields.nullable().number("calibration_us", row.calibration_us, {});
  fields.object("timed_on", row.timed_on, visit_struct);
  fields.required().nullable().number("frames_per_s", row.frames_per_s, {});
  fields.required().integer("throughput_batch", row.throughput_batch, 0, most);
  fields.required().nullable().number("fit_s", row.fit_s, {});
  fields.required().nullable().number("peak_rss_mb", row.peak_rss_mb, {});
  fields.object("seeds", row.seeds, visit_struct);
  visit(fields, row.build);
  fields.any("sweep", row.sweep);
}

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

std::vector<double> those_there(const std::vector<std::optional<double>>& values) {
  std::vector<double> there;
  for (const std::optional<double>& value : values) {
    if (value) there.push_back(*value);
  }
  return there;
}

std::optional<double> SeedSpread::usual_fit_s() const {
  const std::vector<double> there = those_there(fit_s);
  return there.empty() ? std::nullopt : std::optional(median(there));
}

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

json to_json(const ResultRow& row) {
  ResultRow copy = row;
  return Fields::written([&](Fields& fields) { visit(fields, copy); });
}

ResultRow result_row_from_json(JsonObject object) {
  ResultRow row;
  Fields::read(std::move(object), [&](Fields& fields) { visit(fields, row); });
  if (row.seeds) row.fit_s = row.seeds->usual_fit_s();  // earlier versions wrote the mean
  return row;
}

const ResultRow* find_row(std::span<const ResultRow> rows, const std::string& label,
                          const std::string& dataset) {
  const auto found = std::ranges::find_if(
      rows, [&](const ResultRow& row) { return row.label == label && row.dataset == dataset; });
  return found == rows.end() ? nullptr : &*found;
}

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
