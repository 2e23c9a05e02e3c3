#include "bench/report/result_table.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/record/limit_file.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr const char* kDash = "—";
constexpr const char* kWorseThanNothing = "worse than no contact";
constexpr std::size_t kLabelLength = 60;
constexpr std::size_t kMessageLength = 60;
constexpr std::size_t kNoteLength = 1000;

/// Three digits that count, or a dash.
Cell short_cell(const std::optional<double>& value) {
  Cell cell(value ? three_digits(*value) : kDash);
  cell.value = value;
  return cell;
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

/// "paper 1.231 (−0.129)"; empty where the paper has no value.
std::string paper_text(const ResultRow& row, Metric metric, const PublishedTable& published) {
  const auto paper = published_value(published, row, metric);
  if (!paper) return "";
  const int decimals = decimals_of(metric);
  const auto& mean = row.metrics[metric].mean;
  return "paper " + fixed(*paper, decimals) +
         (mean ? " (" + sign_and_number(*mean - *paper, decimals) + ")" : "");
}

Cell metric_cell(const ResultRow& row, Metric metric, const PublishedTable& published) {
  const MetricSummary& summary = row.metrics[metric];
  const MetricEntry& entry = entry_of(metric);
  Cell cell = number_cell(summary.mean, entry.decimals);
  if (entry.published && summary.ci95) {
    cell.interval = interval_text(fixed(summary.ci95->low, entry.decimals),
                                  fixed(summary.ci95->high, entry.decimals));
  }
  std::vector<std::string> lines;
  if (summary.mean) lines.push_back(spread_text(row, metric));
  if (entry.published) lines.push_back(paper_text(row, metric, published));
  if (summary.undefined > 0) lines.push_back(std::to_string(summary.undefined) + " undefined");
  for (std::string& line : lines) {
    if (!line.empty()) cell.lines.push_back(std::move(line));
  }
  return cell;
}

Cell label_cell(const ResultRow& row, std::span<const ResultRow> rows) {
  Cell label = one_line(row.label, kLabelLength);
  if (worse_than_no_contact(row, rows)) label.lines.emplace_back(kWorseThanNothing);
  if (row.ok()) return label;
  const std::string message = one_line(row.message, kMessageLength);
  label.lines.push_back(message.empty() ? row.status : row.status + ": " + message);
  return label;
}

/// The paper's metrics first, which are a part of their own where the page is narrow.
std::vector<Metric> metrics_in_order() {
  std::vector<Metric> metrics(kPublishedMetrics.begin(), kPublishedMetrics.end());
  for (const MetricEntry& entry : kMetricTable) {
    if (!entry.published) metrics.push_back(entry.metric);
  }
  return metrics;
}

/// Where the page is narrow: the paper's metrics; the other ones of images, with times and counts;
/// those of contacts.
int part_of(const MetricEntry& entry) { return entry.published ? 0 : entry.of_contacts() ? 2 : 1; }

bool has_limits(std::span<const ResultRow> rows) { return std::ranges::any_of(rows, is_limit); }

using LatencyPart = std::optional<double> LatencySummary::*;

/// Of times that only some solvers, or only newer results, have.
bool any_has(std::span<const ResultRow> rows, LatencyPart part) {
  return std::ranges::any_of(
      rows, [&](const ResultRow& row) { return member_of(row.latency_us, part).has_value(); });
}

/// The parts that some row has, with the titles of their columns.
std::vector<std::pair<std::string, LatencyPart>> parts_of(std::span<const ResultRow> rows) {
  std::vector<std::pair<std::string, LatencyPart>> out;
  for (const auto& [title, part] : {std::pair{"to contacts (µs)", &LatencySummary::contacts_p50},
                                    std::pair{"pipe (µs)", &LatencySummary::pipe}}) {
    if (any_has(rows, part)) out.emplace_back(title, part);
  }
  return out;
}

std::vector<Column> result_columns(std::span<const ResultRow> rows) {
  std::vector<Column> out = {{"Solver", Align::left}};
  for (const Metric metric : metrics_in_order()) {
    const MetricEntry& entry = entry_of(metric);
    out.emplace_back(entry.heading, Align::right, part_of(entry));
  }
  const auto add = [&](const std::string& title) { out.emplace_back(title, Align::right, 1); };
  if (has_limits(rows)) add("error / limit");
  add("p50 (µs)");
  add("p99 (µs)");
  for (const auto& [title, part] : parts_of(rows)) add(title);
  for (const char* title : {"frames/s", "fit (s)", "memory (MB)", "undef. / not conv. / suspect"}) {
    add(title);
  }
  return out;
}

/// `usual`: the processor of most rows.
std::vector<Cell> cells_of(const ResultRow& row, std::span<const ResultRow> rows,
                           const std::string& usual, const PublishedTable& published) {
  std::vector<Cell> cells = {label_cell(row, rows)};
  for (const Metric metric : metrics_in_order()) {
    cells.push_back(metric_cell(row, metric, published));
  }
  if (has_limits(rows)) {
    cells.push_back(number_cell(member_of(row.over_limit, &OverLimit::ratio), 2));
  }
  std::vector<std::optional<double>> times = {member_of(row.latency_us, &LatencySummary::p50),
                                              member_of(row.latency_us, &LatencySummary::p99)};
  for (const auto& [title, part] : parts_of(rows)) times.push_back(member_of(row.latency_us, part));
  times.push_back(row.frames_per_s);
  for (const std::optional<double>& time : times) {
    cells.push_back(short_cell(time));
    if (time && timed_elsewhere(row, usual)) cells.back().text += " †";
  }
  const bool stored = row.parameters->contains("checkpoint");
  cells.push_back(stored ? Cell("stored") : short_cell(row.fit_s));
  cells.push_back(number_cell(row.peak_rss_mb, 0));
  const bool reconstructed = row.frames > 0;
  cells.emplace_back(reconstructed ? std::to_string(row.undefined_frames) + " / " +
                                         std::to_string(row.frames_not_converged) + " / " +
                                         std::to_string(row.suspect_frames)
                                   : kDash);
  return cells;
}

/// " The true images themselves score RES 82.78.": of each metric whose ideal is that of the truth.
std::string scores_of_truth(const ResultRow& truth) {
  std::string out;
  for (const MetricEntry& entry : kMetricTable) {
    const auto& mean = truth.metrics[entry.metric].mean;
    if (!entry.ideal.of_truth || !mean) continue;
    out += (out.empty() ? " The true images themselves score " : ", ") + std::string(entry.name) +
           " " + fixed(*mean, entry.decimals);
  }
  return out.empty() ? out : out + ".";
}

std::string description_of(const std::string& dataset, std::span<const ResultRow> rows,
                           const TableText& text) {
  int frames = 0;
  std::string truth;
  for (const ResultRow& row : rows) {
    if (row.dataset != dataset) continue;
    frames = std::max(frames, row.frames);
    if (row.type == "truth") truth = scores_of_truth(row);
  }
  std::string out;
  const auto found = text.dataset_descriptions.find(dataset);
  if (found != text.dataset_descriptions.end()) out += one_line(found->second, kNoteLength) + "; ";
  return out + std::to_string(frames) + (frames == 1 ? " frame." : " frames.") + truth;
}

/// The section of a test set; a new one where there is none yet.
TableSection& section_of(Table& table, const std::string& dataset,
                         const std::vector<Column>& columns) {
  for (TableSection& section : table.sections) {
    if (section.caption == dataset) return section;
  }
  TableSection& section = table.sections.emplace_back();
  section.caption = dataset;
  section.columns = columns;
  return section;
}

std::string note_of(const ResultRow& row) {
  return one_line(row.label, kLabelLength) + ", " + row.status + ": " +
         one_line(row.message, kNoteLength);
}

/// "fcnn, dd-ert (2 of 3 seeds)": the rows with a training that used its budget up, each once.
std::string labels_not_converged(std::span<const ResultRow> rows) {
  std::vector<std::string> names;
  for (const ResultRow& row : rows) {
    const Convergence convergence = convergence_of(row);
    if (convergence.all()) continue;
    std::string name = one_line(row.label, kLabelLength);
    if (convergence.runs > 1) {
      name += " (" + std::to_string(convergence.not_converged) + " of " +
              std::to_string(convergence.runs) + " seeds)";
    }
    names.push_back(std::move(name));
  }
  return joined(distinct(names));
}

/// The rows whose solvers could not be fitted to know noise and range, each once.
std::string labels_without_limits(std::span<const ResultRow> rows) {
  std::vector<std::string> names;
  for (const ResultRow& row : rows) {
    if (row.parameters->contains("frame_check")) {
      names.push_back(one_line(row.label, kLabelLength));
    }
  }
  return joined(distinct(names));
}

std::vector<std::string> legend_of(std::span<const ResultRow> rows, const TableText& text) {
  std::vector<std::string> out = {"δσ: the change of the conductivity σ from its background."};
  for (const MetricEntry& entry : kMetricTable) {
    out.push_back(std::string(entry.heading) + ": " + entry.legend);
  }
  if (has_limits(rows)) {
    out.emplace_back(
        "limit-oracle, limit-fair: the best known estimates, of the posterior over scenes of each "
        "frame, under the distribution of the test scenes and of the training scenes; each metric "
        "by an estimate of its own, on the set's first frames. limit-lower: no method's mean can "
        "be expected below it. error / limit: the mean relative error of δσ over that of "
        "limit-oracle, both on these frames.");
  }
  const std::string usual = usual_processor(rows);
  out.push_back(
      "p50, p99: time from the raw voltages to the image of one frame, one thread" +
      (usual.empty() ? "" : " of " + printable(usual)) +
      ". frames/s: throughput with a batch. fit: preparation before the first frame, once (stored: "
      "loaded already fitted). memory: the most that the process of the solver held.");
  if (any_has(rows, &LatencySummary::contacts_p50)) {
    out.emplace_back(
        "to contacts: p50 from the raw voltages to the contacts, which the solver finds itself or "
        "the rule of the experiment reads in the image.");
  }
  if (any_has(rows, &LatencySummary::pipe)) {
    out.emplace_back(
        "pipe: of a solver that is a program of its own, the part of p50 that the way there and "
        "back takes: the median of the same bytes through a program that only answers.");
  }
  out.emplace_back(
      "undef. / not conv. / suspect: frames without a usable image / frames whose iteration did "
      "not converge / frames with an image that the solver itself would not trust (a dead "
      "electrode, noise, voltages out of the range of its validation frames), which are in all "
      "means. A metric that is undefined for a frame (an empty image has no centroid) is counted "
      "and left out of the mean; — is a value that does not exist.");
  out.push_back("Mean [95 % interval]: percentile bootstrap of the mean over the frames, " +
                std::to_string(kBootstrapResamples) + " resamples.");
  if (std::ranges::any_of(rows, [](const ResultRow& r) { return r.seeds.has_value(); })) {
    out.push_back(
        "± over seeds: sample standard deviation of the means of the training runs, which differ "
        "by their seed alone. The mean is the mean of theirs; the interval is that over the "
        "frames, each frame's value being its mean over the seeds. fit is the seeds' mean; p50, "
        "p99 and frames/s are the first seed's: all have the same architecture.");
  }
  if (const std::string labels = labels_not_converged(rows); !labels.empty()) {
    out.push_back(
        "had not converged: " + labels +
        ". Their best epoch was the last that they were allowed: the error on the validation set "
        "was still falling when the budget of epochs ended, and a longer training may do better. "
        "Under a learning rate that falls to 0 with the budget (one-cycle) a training mostly ends "
        "so; this says nothing of how much there is to gain.");
  }
  if (const std::string labels = labels_without_limits(rows); !labels.empty()) {
    out.push_back(
        "frames not checked for noise and range: " + labels +
        ". The limits are fitted on 100 or more frames of the validation set (of the training set "
        "where there is none), and there were fewer: only electrodes that read zero make a frame "
        "suspect.");
  }
  for (std::string& remark : timing_remarks(rows)) out.push_back(std::move(remark));
  if (std::ranges::any_of(rows,
                          [&](const ResultRow& row) { return worse_than_no_contact(row, rows); })) {
    out.push_back(std::string(kWorseThanNothing) +
                  ": the mean relative error of δσ is larger than that of the image without a "
                  "contact.");
  }
  if (!text.builds.empty()) out.push_back(text_of(text.builds));
  if (!text.published.rows.empty()) {
    out.push_back("paper: " + text.published.source +
                  "; in brackets the mean here minus the paper's value.");
  }
  return out;
}

/// What the terminal says of a row's frames behind its numbers.
Cell status_cell(const ResultRow& row, std::span<const ResultRow> rows, const std::string& usual) {
  Cell cell = row.status;
  if (worse_than_no_contact(row, rows)) cell.text += std::string(", ") + kWorseThanNothing;
  if (timed_elsewhere(row, usual)) cell.text += ", timed on another processor";
  const auto count = [&](int frames, const char* what) {
    if (frames > 0) cell.text += ", " + std::to_string(frames) + " " + what;
  };
  count(row.undefined_frames, "undefined");
  count(row.frames_not_converged, "not converged");
  count(row.suspect_frames, "suspect");
  if (row.seeds && row.seeds->values.size() > 1) {
    cell.lines = {"over " + std::to_string(row.seeds->values.size()) + " seeds"};
  }
  return cell;
}

}  // namespace

Table result_table(std::span<const ResultRow> rows, const TableText& text) {
  Table table;
  table.title = text.title;
  const std::string usual = usual_processor(rows);
  for (const ResultRow& row : rows) {
    TableSection& section = section_of(table, row.dataset, result_columns(rows));
    section.rows.push_back(cells_of(row, rows, usual, text.published));
    if (row.message.size() > kMessageLength) section.notes.push_back(note_of(row));
  }
  for (TableSection& section : table.sections) {
    section.text = description_of(section.caption, rows, text);
  }
  table.legend = legend_of(rows, text);
  table.command = text.command;
  return table;
}

Table result_summary(std::span<const ResultRow> rows) {
  std::vector<Column> columns = {{"solver", Align::left}};
  for (const Metric metric : kHeadlineMetrics) columns.emplace_back(entry_of(metric).heading);
  for (const char* title : {"p50 (µs)", "p99 (µs)", "frames/s"}) columns.emplace_back(title);
  columns.emplace_back("status", Align::left);
  Table table;
  const std::string usual = usual_processor(rows);
  for (const ResultRow& row : rows) {
    TableSection& section = section_of(table, row.dataset, columns);
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells.emplace_back(row.label);
    for (const Metric metric : kHeadlineMetrics) {
      Cell& cell = cells.emplace_back(number_cell(row.metrics[metric].mean, decimals_of(metric)));
      if (!row.seeds || row.seeds->values.size() < 2) continue;
      const auto& deviation = row.seeds->deviation[metric];
      cell.lines = {deviation ? "±" + fixed(*deviation, decimals_of(metric)) : kDash};
    }
    cells.push_back(number_cell(member_of(row.latency_us, &LatencySummary::p50), 1));
    cells.push_back(number_cell(member_of(row.latency_us, &LatencySummary::p99), 1));
    cells.push_back(number_cell(row.frames_per_s, 0));
    cells.push_back(status_cell(row, rows, usual));
    if (!row.message.empty()) section.notes.push_back(note_of(row));
  }
  return table;
}

}  // namespace ertbench
