#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "bench/report/table.h"
#include "bench/report/table_cells.h"
#include "core/csv_field.h"

namespace ertbench {
namespace {

/// The shortest text that reads back as the same number.
std::string number(const std::optional<double>& value) {
  if (!value || !std::isfinite(*value)) return "";
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.begin(), buffer.end(), *value);
  return {buffer.begin(), end.ptr};
}

std::string head() {
  std::string line =
      "dataset,label,type,status,message,frames,undefined_frames,frames_not_converged,suspect_"
      "frames";
  for (const Metric metric : kMetrics) {
    for (const char* part : {"mean", "low", "high", "median", "median_low", "median_high", "count",
                             "undefined", "seed_deviation"}) {
      line += std::string(",") + name_of(metric) + "_" + part;
    }
    if (!entry_of(metric).published) continue;
    for (const char* part : {"paper", "difference"}) {
      line += std::string(",") + name_of(metric) + "_" + part;
    }
  }
  return line +
         ",latency_p50_us,latency_p99_us,latency_max_us,frames_per_s,throughput_batch,fit_s,"
         "peak_rss_mb,seeds,sweep,parameters\n";
}

std::string seeds_of(const ResultRow& row) {
  std::string out;
  if (!row.seeds) return out;
  for (const int seed : row.seeds->values) out += (out.empty() ? "" : " ") + std::to_string(seed);
  return out;
}

std::string ends(const std::optional<Interval>& interval) {
  if (!interval) return ",,";
  return "," + number(interval->low) + "," + number(interval->high);
}

std::string metric_fields(const ResultRow& row, Metric metric, const PublishedTable& published) {
  const MetricSummary& summary = row.metrics[metric];
  std::string fields = "," + number(summary.mean) + ends(summary.ci95) + "," +
                       number(summary.median) + ends(summary.median_ci95) + "," +
                       std::to_string(summary.count) + "," + std::to_string(summary.undefined) +
                       "," + number(row.seeds ? row.seeds->deviation[metric] : std::nullopt);
  if (!entry_of(metric).published) return fields;
  const std::optional<double> paper = published_value(published, row, metric);
  std::optional<double> difference;
  if (paper && summary.mean) difference = *summary.mean - *paper;
  return fields + "," + number(paper) + "," + number(difference);
}

}  // namespace

std::string csv_table(std::span<const ResultRow> rows, const PublishedTable& published) {
  std::string out = head();
  for (const ResultRow& row : rows) {
    out += csv_field(row.dataset) + "," + csv_field(row.label) + "," + csv_field(row.type) + "," +
           csv_field(row.status) + "," + csv_field(row.message) + "," + std::to_string(row.frames) +
           "," + std::to_string(row.undefined_frames) + "," +
           std::to_string(row.frames_not_converged) + "," + std::to_string(row.suspect_frames);
    for (const Metric metric : kMetrics) out += metric_fields(row, metric, published);
    const auto latency = [&](double LatencySummary::*part) {
      return number(row.latency_us ? std::optional((*row.latency_us).*part) : std::nullopt);
    };
    out += "," + latency(&LatencySummary::p50) + "," + latency(&LatencySummary::p99) + "," +
           latency(&LatencySummary::max) + "," + number(row.frames_per_s) + "," +
           (row.throughput_batch > 0 ? std::to_string(row.throughput_batch) : "") + "," +
           number(row.fit_s) + "," + number(row.peak_rss_mb) + "," + seeds_of(row) + "," +
           csv_field(row.sweep.text()) + "," + csv_field(row.parameters.text()) + "\n";
  }
  return out;
}

}  // namespace ertbench
