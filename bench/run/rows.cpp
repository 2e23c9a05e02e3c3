#include "bench/run/rows.h"

#include <algorithm>

#include "bench/run/seeds.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t most_message = 2000;  ///< characters, of all its seeds

/// A trial that did not go as it should.
struct Remark {
  std::optional<int> seed;
  Failure what;
};

/// All remarks in one status and message: the first one's status; the seeds are named where not all
/// of them share it.
void apply(const std::vector<Remark>& remarks, std::size_t trials, ResultRow& row) {
  if (remarks.empty()) return;
  row.status = remarks.front().what.status;
  row.message.clear();
  const bool shared =
      remarks.size() == trials && std::all_of(remarks.begin(), remarks.end(), [&](const Remark& r) {
        return r.what.text() == remarks.front().what.text();
      });
  if (shared || !remarks.front().seed) {
    row.message = remarks.front().what.message;
    return;
  }
  for (const Remark& remark : remarks) {
    const bool same_status = remark.what.status == row.status && !remark.what.message.empty();
    row.message += (row.message.empty() ? "seed " : "; seed ") + std::to_string(*remark.seed) +
                   ": " + (same_status ? remark.what.message : remark.what.text());
  }
}

ResultRow empty_row(const SolverEntry& entry, const DatasetSpec& test) {
  ResultRow row;
  row.label = entry.label;
  row.type = entry.type;
  row.dataset = test.name;
  row.parameters = entry.spec;
  return row;
}

/// The numbers and the statuses of one test set.
ResultRow scored_row(const DatasetSpec& test, std::size_t set,
                     std::span<const ScoredTrial> trials) {
  std::vector<SeedResult> results;
  std::vector<Remark> missing;
  std::vector<Remark> reported;
  for (const ScoredTrial& trial : trials) {
    if (!trial.accuracy) {
      missing.push_back({trial.entry->seed, trial.failure});
      continue;
    }
    const ScoredSet& scored = trial.accuracy->sets.at(set);
    results.push_back({trial.entry->seed.value_or(0), &scored});
    if (!scored.row.ok()) {
      reported.push_back({trial.entry->seed, {scored.row.status, scored.row.message}});
    }
  }
  const SolverEntry& entry = *trials.front().entry;
  ResultRow row;
  if (results.empty()) {
    row = empty_row(entry, test);
  } else {
    row = entry.seed ? combine_seeds(results) : results.front().set->row;
  }
  row.family = entry.family;
  row.sweep = entry.sweep;
  std::vector<Remark> remarks = missing;
  remarks.insert(remarks.end(), reported.begin(), reported.end());
  row.status = "ok";
  apply(remarks, trials.size(), row);
  row.status = printable(row.status);
  row.message = printable(row.message, most_message);
  if (!missing.empty() && !results.empty()) {
    row.message += "; the numbers are of the other " +
                   (results.size() == 1 ? "seed" : std::to_string(results.size()) + " seeds");
  }
  return row;
}

/// The metrics on the validation set, of all seeds that were scored.
std::optional<PerMetric<MetricSummary>> validation_of(std::span<const ScoredTrial> trials) {
  std::vector<SeedResult> results;
  for (const ScoredTrial& trial : trials) {
    if (!trial.accuracy || !trial.accuracy->validation) continue;
    results.push_back({trial.entry->seed.value_or(0), &*trial.accuracy->validation});
  }
  if (results.empty()) return std::nullopt;
  return combine_seeds(results).metrics;
}

}  // namespace

std::vector<ResultRow> rows_of(std::span<const DatasetSpec> tests,
                               std::span<const ScoredTrial> trials) {
  std::vector<ResultRow> rows;
  for (std::size_t set = 0; set < tests.size(); ++set) {
    rows.push_back(scored_row(tests[set], set, trials));
    rows.back().validation = validation_of(trials);
  }
  return rows;
}

void add_times(std::span<const TimedTrial> trials, ResultRow& row) {
  for (const TimedTrial& trial : trials) {
    if (trial.timing && trial.timing->sets.count(row.dataset)) {
      const MeasuredTimes& times = trial.timing->sets.at(row.dataset);
      row.latency_us = times.latency_us;
      row.frames_per_s = times.frames_per_s;
      row.throughput_batch = times.batch;
      row.timed_on = trial.timing->place;
      row.calibration_us = trial.timing->calibration_us;
      row.peak_rss_mb = trial.timing->peak_rss_mb;
      return;
    }
    if (trial.failure) {
      const std::string seed =
          trial.entry->seed ? "seed " + std::to_string(*trial.entry->seed) + ": " : "";
      const std::string before = row.message.empty() ? "" : row.message + "; ";
      row.message = before + seed + "timing: " + printable(trial.failure->message, most_message);
      row.status = printable(trial.failure->status);
      return;
    }
  }
}

}  // namespace ertbench
