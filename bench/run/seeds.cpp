#include "bench/run/seeds.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/score/metric_summary.h"
#include "core/moments.h"

namespace ertbench {
namespace {

using nlohmann::json;

using Values = std::vector<std::optional<double>>;

std::vector<double> those_there(const Values& values) {
  std::vector<double> there;
  for (const auto& value : values) {
    if (value) there.push_back(*value);
  }
  return there;
}

std::optional<double> mean_of(const Values& values) {
  const std::vector<double> there = those_there(values);
  return there.empty() ? std::nullopt : std::optional(mean(there));
}

std::optional<double> deviation_of(const Values& values) {
  const std::vector<double> there = those_there(values);
  return there.size() < 2 ? std::nullopt : std::optional(sample_deviation(there));
}

/// Each frame's mean over the seeds, undefined where it is so for one of them.
Values frame_means(std::span<const SeedResult> results, Metric metric) {
  Values values(results.front().set->frames.size());
  for (std::size_t frame = 0; frame < values.size(); ++frame) {
    Values of_seeds;
    for (const SeedResult& result : results) {
      of_seeds.push_back(result.set->frames[frame][metric]);
    }
    const bool all = std::all_of(of_seeds.begin(), of_seeds.end(),
                                 [](const auto& value) { return value && std::isfinite(*value); });
    if (all) values[frame] = mean_of(of_seeds);
  }
  return values;
}

int frames_with_any(std::span<const SeedResult> results, FrameStatus status) {
  int count = 0;
  for (std::size_t frame = 0; frame < results.front().set->statuses.size(); ++frame) {
    count += std::any_of(results.begin(), results.end(), [&](const SeedResult& result) {
      return result.set->statuses[frame] == status;
    });
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
          std::all_of(all.begin(), all.end(), [&, &name = key, &mine = value](const json& other) {
            return other.contains(name) && other.at(name) == mine;
          });
      if (!same) different[key] = value;
    }
    out.push_back(std::move(different));
  }
  return out;
}

}  // namespace

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
  row.fit_s = mean_of(spread.fit_s);
  spread.parameters = different_parameters(results);
  for (const Metric metric : kMetrics) {
    for (const SeedResult& result : results) {
      spread.means[metric].push_back(result.set->row.metrics[metric].mean);
    }
    spread.deviation[metric] = deviation_of(spread.means[metric]);
    const MetricSummary& first = results.front().set->row.metrics[metric];
    if (row.frames > 0 && first.count + first.undefined == 0) continue;  // the truth tells it not
    row.metrics[metric] = summarise(frame_means(results, metric), name_of(metric));
    row.metrics[metric].mean = mean_of(spread.means[metric]);
  }
  row.undefined_frames = frames_with_any(results, FrameStatus::undefined);
  row.frames_not_converged = frames_with_any(results, FrameStatus::not_converged);
  row.suspect_frames = frames_with_any(results, FrameStatus::suspect);
  return row;
}

}  // namespace ertbench
