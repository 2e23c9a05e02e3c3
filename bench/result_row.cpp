#include "bench/result_row.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "forward/json_reader.h"

namespace ertbench {
namespace {

using nlohmann::json;

json or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? json(*value) : json(nullptr);
}

json to_json(const MetricSummary& summary) {
  json ci95 = nullptr;
  if (summary.ci95) ci95 = {summary.ci95->low, summary.ci95->high};
  return {{"mean", or_null(summary.mean)},
          {"ci95", std::move(ci95)},
          {"median", or_null(summary.median)},
          {"count", summary.count},
          {"undefined", summary.undefined}};
}

json to_json(const LatencySummary& latency) {
  return {{"p50", latency.p50}, {"p99", latency.p99}, {"max", latency.max}};
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

MetricSummary metric_summary_from_json(JsonObject object) {
  MetricSummary summary;
  summary.mean = number_or_null(object, "mean");
  if (!is_null(object, "ci95")) {
    const auto ends = object.numbers("ci95", 2);
    summary.ci95 = Interval{ends[0], ends[1]};
  }
  summary.median = number_or_null(object, "median");
  summary.count = count(object, "count");
  summary.undefined = count(object, "undefined");
  object.finish();
  return summary;
}

LatencySummary latency_from_json(JsonObject object) {
  const LatencySummary latency{object.number("p50"), object.number("p99"), object.number("max")};
  object.finish();
  return latency;
}

}  // namespace

json to_json(const ResultRow& row) {
  json parameters = json::parse(row.parameters_json, nullptr, false);
  if (parameters.is_discarded()) {
    throw std::invalid_argument("row " + row.label +
                                ": parameters are not JSON: " + row.parameters_json);
  }
  json metrics = json::object();
  for (const Metric metric : kMetrics) metrics[name_of(metric)] = to_json(row.metrics[metric]);
  return {{"label", row.label},
          {"type", row.type},
          {"dataset", row.dataset},
          {"status", row.status},
          {"message", row.message},
          {"parameters", std::move(parameters)},
          {"frames", row.frames},
          {"undefined_frames", row.undefined_frames},
          {"frames_not_converged", row.frames_not_converged},
          {"metrics", std::move(metrics)},
          {"latency_us", row.latency_us ? to_json(*row.latency_us) : json(nullptr)},
          {"frames_per_s", or_null(row.frames_per_s)},
          {"throughput_batch", row.throughput_batch},
          {"fit_s", or_null(row.fit_s)},
          {"peak_rss_mb", or_null(row.peak_rss_mb)}};
}

ResultRow result_row_from_json(JsonObject object) {
  ResultRow row;
  row.label = object.text("label");
  row.type = object.text("type");
  row.dataset = object.text("dataset");
  row.status = object.text("status");
  row.message = any_text(object, "message");
  row.parameters_json = object.raw("parameters").dump();
  row.frames = count(object, "frames");
  row.undefined_frames = count(object, "undefined_frames");
  row.frames_not_converged = count(object, "frames_not_converged");
  JsonObject metrics = object.object("metrics");
  for (const Metric metric : kMetrics) {
    row.metrics[metric] = metric_summary_from_json(metrics.object(name_of(metric)));
  }
  metrics.finish();
  if (!is_null(object, "latency_us")) {
    row.latency_us = latency_from_json(object.object("latency_us"));
  }
  row.frames_per_s = number_or_null(object, "frames_per_s");
  row.throughput_batch = count(object, "throughput_batch");
  row.fit_s = number_or_null(object, "fit_s");
  row.peak_rss_mb = number_or_null(object, "peak_rss_mb");
  object.finish();
  return row;
}

}  // namespace ertbench
