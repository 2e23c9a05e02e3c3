#include "bench/report/published_value.h"
#include "bench/report/result_table.h"

namespace ertbench {
namespace {

std::vector<Column> data_columns() {
  std::vector<Column> out = {"dataset",
                             "label",
                             "type",
                             "status",
                             "message",
                             "frames",
                             "undefined_frames",
                             "frames_not_converged",
                             "suspect_frames"};
  for (const MetricEntry& entry : kMetricTable) {
    const auto add = [&](const char* part) { out.emplace_back(entry.name + std::string(part)); };
    for (const char* part : {"_mean", "_low", "_high", "_median", "_median_low", "_median_high",
                             "_count", "_undefined", "_seed_deviation"}) {
      add(part);
    }
    if (!entry.published) continue;
    add("_paper");
    add("_difference");
  }
  for (const char* title : {"relative_error_over_limit", "relative_error_over_limit_low",
                            "relative_error_over_limit_high", "latency_p50_us", "latency_p99_us",
                            "latency_max_us", "latency_pipe_us", "frames_per_s", "throughput_batch",
                            "fit_s", "peak_rss_mb", "seeds", "sweep", "parameters"}) {
    out.emplace_back(title);
  }
  return out;
}

std::string seeds_of(const ResultRow& row) {
  std::string out;
  if (!row.seeds) return out;
  for (const int seed : row.seeds->values) out += (out.empty() ? "" : " ") + std::to_string(seed);
  return out;
}

void add_ends(const std::optional<Interval>& interval, std::vector<Cell>& cells) {
  cells.push_back(exact_cell(interval ? std::optional(interval->low) : std::nullopt));
  cells.push_back(exact_cell(interval ? std::optional(interval->high) : std::nullopt));
}

void add_metric(const ResultRow& row, Metric metric, const PublishedTable& published,
                std::vector<Cell>& cells) {
  const MetricSummary& summary = row.metrics[metric];
  cells.push_back(exact_cell(summary.mean));
  add_ends(summary.ci95, cells);
  cells.push_back(exact_cell(summary.median));
  add_ends(summary.median_ci95, cells);
  cells.emplace_back(std::to_string(summary.count));
  cells.emplace_back(std::to_string(summary.undefined));
  cells.push_back(exact_cell(row.seeds ? row.seeds->deviation[metric] : std::nullopt));
  if (!entry_of(metric).published) return;
  const std::optional<double> paper = published_value(published, row, metric);
  cells.push_back(exact_cell(paper));
  cells.push_back(
      exact_cell(paper && summary.mean ? std::optional(*summary.mean - *paper) : std::nullopt));
}

}  // namespace

TableSection result_data(std::span<const ResultRow> rows, const PublishedTable& published) {
  TableSection section;
  section.columns = data_columns();
  for (const ResultRow& row : rows) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells = {row.dataset,
             row.label,
             row.type,
             row.status,
             row.message,
             std::to_string(row.frames),
             std::to_string(row.undefined_frames),
             std::to_string(row.frames_not_converged),
             std::to_string(row.suspect_frames)};
    for (const Metric metric : kMetrics) add_metric(row, metric, published, cells);
    cells.push_back(
        exact_cell(row.over_limit ? std::optional(row.over_limit->ratio) : std::nullopt));
    add_ends(row.over_limit ? std::optional(row.over_limit->ci95) : std::nullopt, cells);
    const auto latency = [&](double LatencySummary::*part) {
      return exact_cell(row.latency_us ? std::optional((*row.latency_us).*part) : std::nullopt);
    };
    cells.push_back(latency(&LatencySummary::p50));
    cells.push_back(latency(&LatencySummary::p99));
    cells.push_back(latency(&LatencySummary::max));
    cells.push_back(exact_cell(row.latency_us ? row.latency_us->pipe : std::nullopt));
    cells.push_back(exact_cell(row.frames_per_s));
    cells.emplace_back(row.throughput_batch > 0 ? std::to_string(row.throughput_batch) : "");
    cells.push_back(exact_cell(row.fit_s));
    cells.push_back(exact_cell(row.peak_rss_mb));
    cells.emplace_back(seeds_of(row));
    cells.emplace_back(row.sweep.text());
    cells.emplace_back(row.parameters.text());
  }
  return section;
}

}  // namespace ertbench
