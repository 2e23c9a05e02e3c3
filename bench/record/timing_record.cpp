#include "bench/record/timing_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/record/accuracy_record.h"
#include "bench/record/cache.h"
#include "bench/record/record_file.h"
#include "core/quantile.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// p50, p99 and maximum of every frame's time. A percentile is a time that was measured.
LatencySummary summarise_latency(const SortedValues& microseconds) {
  return {nearest_rank_quantile(microseconds, 0.5),
          nearest_rank_quantile(microseconds, 0.99),
          microseconds.largest(),
          {},
          {},
          {}};
}

/// One test set in all rounds.
struct Rounds {
  std::vector<double> microseconds;
  std::vector<double> p50;
  std::vector<double> relative;
  std::vector<double> frames_per_s;
  std::vector<double> pipe;  ///< microseconds
  int batch = 0;

  void add(const json& times, double calibration_us) {
    const auto some = times.at("latency_us").get<std::vector<double>>();
    p50.push_back(summarise_latency(some).p50);
    relative.push_back(
        relative_latency(p50.back(), *std::min_element(some.begin(), some.end()), calibration_us));
    microseconds.insert(microseconds.end(), some.begin(), some.end());
    frames_per_s.push_back(times.at("frames_per_s").get<double>());
    batch = times.at("batch").get<int>();
    if (times.contains("pipe_us")) {
      const auto alone = times.at("pipe_us").get<std::vector<double>>();
      pipe.insert(pipe.end(), alone.begin(), alone.end());
    }
  }
};

}  // namespace

double relative_latency(double median_us, double fastest_us, double calibration_us) {
  constexpr double long_frame_us = 1000;
  return (fastest_us < long_frame_us ? median_us : fastest_us) / calibration_us;
}

std::string timing_key(const FitRecipe& recipe, std::span<const DatasetSpec> tests,
                       const TimingSettings& timing) {
  json key = {{"schema", record_schema},
              {"metrics", metrics_version},
              {"label", recipe.entry.label},
              {"entry", recipe.entry.spec.text()},
              {"solver", Cache::fitted_solver_key(recipe).dump()},
              {"timing", {timing.frames, timing.warm_up, timing.batch, timing.rounds}}};
  for (const DatasetSpec& test : tests) key["tests"].push_back(to_json(test));
  return hash_of(key.dump());
}

TimingPlace timing_place_of(const json& round) {
  const json& place = round.at("place");
  return {place.at("cpu").get<std::string>(), place.at("node").get<std::string>(),
          place.at("busy_cores").get<double>()};
}

json to_json(const TimingPlace& place) {
  return {{"cpu", place.cpu}, {"node", place.node}, {"busy_cores", place.busy_cores}};
}

TimingRecord timing_record_from_json(const std::vector<json>& rounds) {
  std::map<std::string, Rounds> sets;
  std::vector<double> calibration;
  TimingRecord record;
  for (const json& round : rounds) {
    calibration.push_back(round.at("calibration_us").get<double>());
    for (const auto& [dataset, times] : round.at("timing").items()) {
      sets[dataset].add(times, calibration.back());
    }
    record.peak_rss_mb = std::max(record.peak_rss_mb, round.at("peak_rss_mb").get<double>());
  }
  for (const auto& [dataset, set] : sets) {
    MeasuredTimes times{summarise_latency(set.microseconds), median(set.frames_per_s), set.batch};
    times.latency_us.p50_of_rounds = set.p50;
    times.latency_us.relative_of_rounds = set.relative;
    if (!set.pipe.empty()) times.latency_us.pipe = median(set.pipe);
    record.sets[dataset] = std::move(times);
  }
  record.calibration_us = median(calibration);
  record.place = timing_place_of(rounds.front());
  for (const json& round : rounds) {
    record.place.busy_cores = std::max(record.place.busy_cores, timing_place_of(round).busy_cores);
  }
  return record;
}

}  // namespace ertbench
