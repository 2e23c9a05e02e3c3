#include "bench/report/table_cells.h"

#include <algorithm>

#include "core/bootstrap.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr const char* kDash = "—";
constexpr std::size_t kLabelLength = 60;
constexpr std::size_t kMessageLength = 60;
constexpr std::size_t kNoteLength = 1000;

std::string or_dash(const std::optional<double>& value) {
  return value ? three_digits(*value) : kDash;
}

std::string sign_and_number(double value, int decimals) {
  const std::string number = fixed(value, decimals);
  const bool zero = number.find_first_not_of("0.") == std::string::npos;
  return value > 0 && !zero ? "+" + number : number;
}

/// "± 0.004 over 3 seeds"; empty where there is no deviation.
std::string spread_text(const ResultRow& row, Metric metric) {
  if (!row.seeds || !row.seeds->deviation[metric]) return "";
  return "± " + fixed(*row.seeds->deviation[metric], decimals_of(metric)) + " over " +
         std::to_string(row.seeds->values.size()) + " seeds";
}

Cell metric_cell(const ResultRow& row, Metric metric) {
  const MetricSummary& summary = row.metrics[metric];
  const std::string undefined =
      summary.undefined > 0 ? std::to_string(summary.undefined) + " undefined" : "";
  if (!summary.mean) return {undefined.empty() ? kDash : kDash + (" " + undefined)};
  Cell cell = {fixed(*summary.mean, decimals_of(metric))};
  const std::string spread = spread_text(row, metric);
  if (!spread.empty()) cell.push_back(spread);
  if (!undefined.empty()) cell.push_back(undefined);
  return cell;
}

Cell published_metric_cell(const ResultRow& row, Metric metric, const PublishedTable& published) {
  const MetricSummary& summary = row.metrics[metric];
  const int decimals = decimals_of(metric);
  Cell cell = metric_cell(row, metric);
  if (summary.ci95) {
    cell[0] += " [" + fixed(summary.ci95->low, decimals) + ", " +
               fixed(summary.ci95->high, decimals) + "]";
  }
  if (const auto paper = published_value(published, row, metric)) {
    std::string line = "paper " + fixed(*paper, decimals);
    if (summary.mean) line += " (" + sign_and_number(*summary.mean - *paper, decimals) + ")";
    cell.insert(cell.begin() + (spread_text(row, metric).empty() ? 1 : 2), std::move(line));
  }
  return cell;
}

std::vector<Cell> cells_of(const ResultRow& row, const PublishedTable& published) {
  Cell label = {one_line(row.label, kLabelLength)};
  if (!row.ok()) {
    const std::string message = one_line(row.message, kMessageLength);
    label.push_back(message.empty() ? row.status : row.status + ": " + message);
  }
  std::vector<Cell> cells = {label};
  for (const Metric metric : kPublishedMetrics) {
    cells.push_back(published_metric_cell(row, metric, published));
  }
  for (const MetricEntry& entry : kMetricTable) {
    if (!entry.published) cells.push_back(metric_cell(row, entry.metric));
  }
  cells.push_back({row.latency_us ? three_digits(row.latency_us->p50) : kDash});
  cells.push_back({row.latency_us ? three_digits(row.latency_us->p99) : kDash});
  cells.push_back({or_dash(row.frames_per_s)});
  cells.push_back({or_dash(row.fit_s)});
  cells.push_back({row.peak_rss_mb ? fixed(*row.peak_rss_mb, 0) : kDash});
  const bool reconstructed = row.frames > 0;
  cells.push_back({reconstructed ? std::to_string(row.undefined_frames) + " / " +
                                       std::to_string(row.frames_not_converged) + " / " +
                                       std::to_string(row.suspect_frames)
                                 : kDash});
  return cells;
}

Cell head() {
  Cell out = {"Solver"};
  for (const Metric metric : kPublishedMetrics) out.emplace_back(entry_of(metric).heading);
  for (const MetricEntry& entry : kMetricTable) {
    if (!entry.published) out.emplace_back(entry.heading);
  }
  for (const char* title : {"p50 (µs)", "p99 (µs)", "frames/s", "fit (s)", "memory (MB)",
                            "undef. / not conv. / suspect"}) {
    out.emplace_back(title);
  }
  return out;
}

std::string description_of(const CellTable& table, std::span<const ResultRow> rows,
                           const TableText& text) {
  int frames = 0;
  const MetricSummary* truth = nullptr;
  for (const ResultRow& row : rows) {
    if (row.dataset != table.dataset) continue;
    frames = std::max(frames, row.frames);
    if (row.type == "truth") truth = &row.metrics[Metric::RES];
  }
  std::string out;
  const auto found = text.dataset_descriptions.find(table.dataset);
  if (found != text.dataset_descriptions.end()) out += one_line(found->second, kNoteLength) + "; ";
  out += std::to_string(frames) + (frames == 1 ? " frame." : " frames.");
  if (truth != nullptr && truth->mean) {
    out += " The true images themselves score RES " + fixed(*truth->mean, 2) + ".";
  }
  return out;
}

}  // namespace

std::vector<CellTable> cell_tables(std::span<const ResultRow> rows, const TableText& text) {
  std::vector<CellTable> tables;
  for (const ResultRow& row : rows) {
    auto table = std::find_if(tables.begin(), tables.end(),
                              [&](const CellTable& t) { return t.dataset == row.dataset; });
    if (table == tables.end()) {
      tables.push_back({row.dataset, head(), {}, "", {}});
      table = std::prev(tables.end());
    }
    table->rows.push_back(cells_of(row, text.published));
    if (row.message.size() > kMessageLength) {
      table->notes.push_back(one_line(row.label, kLabelLength) + ", " + row.status + ": " +
                             one_line(row.message, kNoteLength));
    }
  }
  for (CellTable& table : tables) table.description = description_of(table, rows, text);
  return tables;
}

std::vector<std::string> legend(std::span<const ResultRow> rows, const TableText& text) {
  std::vector<std::string> out = {"δσ: the change of the conductivity σ from its background."};
  for (const MetricEntry& entry : kMetricTable) {
    out.push_back(std::string(entry.heading) + ": " + entry.legend);
  }
  out.emplace_back(
      "p50, p99: time from the raw voltages to the image of one frame, one thread. frames/s: "
      "throughput with a batch. fit: preparation before the first frame, once. memory: the most "
      "that the process of the solver held.");
  out.emplace_back(
      "undef. / not conv. / suspect: frames without a usable image / frames whose iteration did "
      "not converge / frames with an image that the solver itself would not trust (a dead "
      "electrode, noise, voltages out of the range of its validation frames), which are in all "
      "means. "
      "A metric that is undefined for a frame (an empty image has no centroid) is counted and left "
      "out of the mean; — is a value that does not exist.");
  out.push_back("Mean [95 % interval]: percentile bootstrap of the mean over the frames, " +
                std::to_string(kBootstrapResamples) + " resamples.");
  if (std::any_of(rows.begin(), rows.end(),
                  [](const ResultRow& r) { return r.seeds.has_value(); })) {
    out.push_back(
        "± over seeds: sample standard deviation of the means of the training runs, which differ "
        "by "
        "their seed alone. The mean is the mean of theirs; the interval is that over the frames, "
        "each frame's value being its mean over the seeds. fit is the seeds' mean; p50, p99 and "
        "frames/s are the first seed's: all have the same architecture.");
  }
  if (!text.published.rows.empty()) {
    out.push_back("paper: " + text.published.source +
                  "; in brackets the mean here minus the paper's value.");
  }
  return out;
}

std::optional<double> published_value(const PublishedTable& published, const ResultRow& row,
                                      Metric metric) {
  const auto& sets = published.datasets;
  if (!sets.empty() && std::find(sets.begin(), sets.end(), row.dataset) == sets.end()) {
    return std::nullopt;
  }
  for (const PublishedRow& candidate : published.rows) {
    if (candidate.label == row.label) return candidate.values[metric];
  }
  return std::nullopt;
}

}  // namespace ertbench
