#include <algorithm>
#include <map>
#include <set>

#include "bench/report/result_table.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {

std::optional<double> published_value(const PublishedTable& published, const ResultRow& row,
                                      Metric metric) {
  const auto& sets = published.datasets;
  if (!sets.empty() && !contains(sets, row.dataset)) return std::nullopt;
  const auto found = std::ranges::find(published.rows, row.label, &PublishedRow::label);
  return found == published.rows.end() ? std::nullopt : found->values[metric];
}

namespace {

constexpr double most_fit_ratio = 2;  ///< of the fit times of one row's seeds without a remark

/// Of each label its first row that was timed.
std::vector<const ResultRow*> timed_labels(std::span<const ResultRow> rows) {
  std::vector<const ResultRow*> out;
  std::set<std::string> known;
  for (const ResultRow& row : rows) {
    if (row.timed_on && known.insert(row.label).second) out.push_back(&row);
  }
  return out;
}

/// A solver in a process of its own works where its trial waits, and is counted there among the
/// others: up to one core of them is its own.
double disturbing_cores(const ResultRow& row) {
  const bool own_process = row.latency_us && row.latency_us->pipe;
  return row.timed_on->busy_cores - (own_process ? 1 : 0);
}

}  // namespace

bool worse_than_no_contact(const ResultRow& row, std::span<const ResultRow> rows) {
  constexpr double rounding = 1e-9;
  const auto& error = row.metrics[Metric::relative_error].mean;
  if (!error || row.type == "no-contact" || row.type == "truth") return false;
  const auto other = std::ranges::find_if(rows, [&](const ResultRow& one) {
    return one.type == "no-contact" && one.dataset == row.dataset;
  });
  if (other == rows.end()) return false;
  const auto& nothing = other->metrics[Metric::relative_error].mean;
  return nothing && *error > *nothing * (1 + rounding);
}

std::string usual_processor(std::span<const ResultRow> rows) {
  std::map<std::string, int> counts;
  std::string usual;
  for (const ResultRow* row : timed_labels(rows)) ++counts[row->timed_on->cpu];
  for (const ResultRow* row : timed_labels(rows)) {
    const std::string& cpu = row->timed_on->cpu;
    if (usual.empty() || counts[cpu] > counts[usual]) usual = cpu;
  }
  return usual;
}

bool timed_elsewhere(const ResultRow& row, const std::string& usual) {
  return row.timed_on && row.timed_on->cpu != usual;
}

std::vector<std::string> timing_remarks(std::span<const ResultRow> rows) {
  const std::string usual = usual_processor(rows);
  std::vector<std::string> elsewhere;
  std::vector<std::string> busy;
  for (const ResultRow* row : timed_labels(rows)) {
    const TimingPlace& place = *row->timed_on;
    const std::string label = printable(row->label);
    if (place.cpu != usual) elsewhere.push_back(label + " (" + printable(place.cpu) + ")");
    if (const double cores = disturbing_cores(*row); cores >= least_disturbing_cores) {
      busy.push_back(label + " (" + fixed(cores, 1) + ")");
    }
  }
  std::vector<std::string> out;
  if (!elsewhere.empty()) {
    out.push_back("†: timed on another processor than the other rows (" + printable(usual) +
                  "), with whose times these must not be compared: " + joined(elsewhere) + ".");
  }
  if (!busy.empty()) {
    out.push_back(
        "timed while other processes kept cores of the machine busy (so many of them on the "
        "average of the busiest round), which lengthens p99 above all: " +
        joined(busy) + ". On an idle machine `--fresh` times them again.");
  }
  std::vector<std::string> fits;
  for (const ResultRow& row : rows) {
    if (!row.seeds || row.dataset != rows.front().dataset) continue;
    const std::vector<double> times = those_there(row.seeds->fit_s);
    if (times.empty()) continue;
    const auto [least, most] = std::ranges::minmax(times);
    if (most <= most_fit_ratio * least) continue;
    fits.push_back(printable(row.label) + " (" + fixed(least, 0) + " to " + fixed(most, 0) + " s)");
  }
  if (!fits.empty()) {
    out.push_back(
        "fitted in very different times by seed, on busy cores or from scenes that another "
        "training had left in the cache; the median stands in the table: " +
        joined(fits) + ".");
  }
  return out;
}

}  // namespace ertbench
