#include "bench/run/rows.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/score/metrics.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

using nlohmann::json;

using Values = std::vector<std::optional<double>>;

/// Each frame's mean over the seeds, undefined where it is so for one of them.
Values frame_means(std::span<const SeedResult> results, Metric metric) {
  Values values(results.front().set->frames.size());
  for (std::size_t frame = 0; frame < values.size(); ++frame) {
    Values of_seeds;
    for (const SeedResult& result : results) {
      of_seeds.push_back(result.set->frames[frame][metric]);
    }
    const bool all = std::ranges::all_of(
        of_seeds, [](const auto& value) { return value && std::isfinite(*value); });
    if (all) values[frame] = mean_of(of_seeds);
  }
  return values;
}

int frames_with_any(std::span<const SeedResult> results, FrameStatus status) {
  int count = 0;
  for (std::size_t frame = 0; frame < results.front().set->statuses.size(); ++frame) {
    count += std::ranges::any_of(
        results, [&](const SeedResult& result) { return result.set->statuses[frame] == status; });
  }
  return count;
}

/// Of each seed's parameters the ones that are not the same for all.
json different_parameters(std::span<const SeedResult> results) {
  std::vector<json> all;
  for (const SeedResult& result : results) all.push_back(*result.set->row.parameters);
  json out = json::array();
  for (const json& one : all) {
    json different = json::object();
    for (const auto& [key, value] : one.items()) {
      const bool same =
          std::ranges::all_of(all, [&, &name = key, &mine = value](const json& other) {
            return other.contains(name) && other.at(name) == mine;
          });
      if (!same) different[key] = value;
    }
    out.push_back(std::move(different));
  }
  return out;
}

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
      remarks.size() == trials && std::ranges::all_of(remarks, [&](const Remark& r) {
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
    row.label = entry.label;
    row.type = entry.type;
    row.dataset = test.name;
    row.parameters = entry.spec;
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

ResultRow row_of(const std::string& label, const DatasetSpec& test,
                 const std::vector<FrameMetrics>& frames, const Truth& known) {
  ResultRow row;
  row.label = row.type = label;
  row.dataset = test.name;
  row.frames = static_cast<int>(frames.size());
  row.metrics = summarise(frames, known);
  return row;
}

/// Both rows of one test set that need no solver.
void add_reference_rows(const Sensor& sensor, const DatasetSpec& test, const DatasetFile& set,
                        const ContactSettings& settings, std::vector<ResultRow>& rows) {
  const ContactDistances distances = settings.distances(sensor);
  const ContactRule rule = settings.rule();
  ContactReader reader(sensor);
  std::vector<FoundContact> found;
  std::vector<FrameMetrics> truth;
  std::vector<FrameMetrics> untouched;
  const Eigen::RowVectorXd nothing = Eigen::RowVectorXd::Zero(sensor.pixels());
  constexpr std::uint64_t block = 256;
  for (std::uint64_t first = 0; first < set.size(); first += block) {
    const std::uint64_t count = std::min(block, set.size() - first);
    const Images images = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::RowVectorXd image = images.row(static_cast<Eigen::Index>(i));
      const Eigen::RowVectorXd change = image.array() - sensor.background;
      reader.read(rule, change, found);
      truth.push_back(frame_metrics(sensor, image, change, scenes[i], {found, distances}));
      untouched.push_back(frame_metrics(sensor, image, nothing, scenes[i], {{}, distances}));
    }
  }
  rows.push_back(row_of("truth", test, truth, set.truth()));
  rows.push_back(row_of("no-contact", test, untouched, set.truth()));
}

}  // namespace

std::optional<double> mean_of(const std::vector<std::optional<double>>& values) {
  const std::vector<double> there = those_there(values);
  return there.empty() ? std::nullopt : std::optional(mean(there));
}

std::optional<double> deviation_of(const std::vector<std::optional<double>>& values) {
  const std::vector<double> there = those_there(values);
  return there.size() < 2 ? std::nullopt : std::optional(sample_deviation(there));
}

ResultRow combine_seeds(std::span<const SeedResult> results) {
  if (results.empty()) throw std::invalid_argument("combine_seeds: no seed");
  for (const SeedResult& result : results) {
    if (result.set->frames.size() != results.front().set->frames.size()) {
      throw std::invalid_argument("combine_seeds: seeds of different test sets");
    }
  }
  ResultRow row = results.front().set->row;
  SeedSpread& spread = row.seeds.emplace();
  for (const SeedResult& result : results) {
    spread.values.push_back(result.seed);
    spread.fit_s.push_back(result.set->row.fit_s);
  }
  row.fit_s = spread.usual_fit_s();
  spread.parameters = different_parameters(results);
  for (const Metric metric : kMetrics) {
    for (const SeedResult& result : results) {
      spread.means[metric].push_back(result.set->row.metrics[metric].mean);
    }
    spread.deviation[metric] = deviation_of(spread.means[metric]);
    const MetricSummary& first = results.front().set->row.metrics[metric];
    if (row.frames > 0 && first.count + first.undefined == 0) continue;  // the truth tells it not
    row.metrics[metric] = summarise(frame_means(results, metric), first_name_of(metric));
    row.metrics[metric].mean = mean_of(spread.means[metric]);
  }
  row.undefined_frames = frames_with_any(results, FrameStatus::undefined);
  row.frames_not_converged = frames_with_any(results, FrameStatus::not_converged);
  row.suspect_frames = frames_with_any(results, FrameStatus::suspect);
  return row;
}

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

std::vector<ResultRow> reference_rows(const Sensor& sensor, std::span<const DatasetSpec> tests,
                                      const ContactSettings& contacts, const Cache& cache) {
  std::vector<ResultRow> rows;
  for (const DatasetSpec& test : tests) {
    add_reference_rows(sensor, test, cache.open_dataset(test), contacts, rows);
  }
  return rows;
}

}  // namespace ertbench
